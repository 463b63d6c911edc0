//! Which panics count as findings.

/// Ends the process at panics of this project's code only: those of the decoders that it is built on
/// are caught and become errors.
pub fn ignore_decoders() {
    let end = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let is_ours = |file: &str| file.contains("stiction") || file.contains("fuzz_targets");
        if panic.location().is_none_or(|location| is_ours(location.file())) {
            end(panic);
        }
    }));
}
