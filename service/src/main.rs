fn main() -> std::process::ExitCode {
    // Mesa's device selection prints an "error" where there is no desktop session, which is everywhere that
    // this program runs, and selects nothing for a program without a window.
    // SAFETY: no other thread exists yet.
    unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    meshcolor_service::cli::main()
}
