//! The files of the page, built from `web/`.

/// A file of the page.
pub struct Asset {
    /// Path at the server.
    pub path: &'static str,
    /// Media type.
    pub kind: &'static str,
    /// Bytes.
    pub bytes: &'static [u8],
}

/// All files of the page. The HTML file comes first.
pub const ASSETS: [Asset; 3] = [
    Asset {
        path: "/",
        kind: "text/html; charset=utf-8",
        bytes: include_bytes!("../web/dist/index.html"),
    },
    Asset {
        path: "/lab.js",
        kind: "text/javascript; charset=utf-8",
        bytes: include_bytes!("../web/dist/lab.js"),
    },
    Asset {
        path: "/lab.css",
        kind: "text/css; charset=utf-8",
        bytes: include_bytes!("../web/dist/lab.css"),
    },
];
