//! The program `gonio-embree`: see `gonio-embree --help`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
