//! A self-contained HTML page that shows figures with their captions and parameters.

