fn main() -> std::process::ExitCode {
    meshcolor_service::cli::main()
}
