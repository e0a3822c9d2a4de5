//! The command line `meshcolor` for the tests of this package: cargo names them no other package's programs.

fn main() -> std::process::ExitCode {
    meshcolor_service::cli::main()
}
