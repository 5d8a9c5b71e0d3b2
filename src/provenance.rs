//! What made a result: program, engine, machine.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What made a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// Commit it was built from; "unknown" outside a checkout.
    pub commit: String,
    /// Engine and version.
    pub engine: String,
    /// Compiler.
    pub compiler: String,
    /// Operating system and architecture.
    pub platform: String,
    /// Processor, where the system tells.
    pub processor: String,
    /// Processors available.
    pub threads: usize,
    /// Command line.
    pub command: String,
}

impl Provenance {
    /// That of this process.
    pub fn here() -> Provenance {
        Provenance {
            program: concat!("tumblenet ", env!("CARGO_PKG_VERSION")).to_owned(),
            commit: env!("TUMBLENET_COMMIT").to_owned(),
            engine: env!("TUMBLENET_ENGINE").to_owned(),
            compiler: env!("TUMBLENET_COMPILER").to_owned(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            command: std::env::args().collect::<Vec<_>>().join(" "),
        }
    }
}

fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = told.lines().find_map(|line| line.strip_prefix("model name"));
    line.and_then(|line| line.split_once(':'))
        .map_or_else(|| "unknown".to_owned(), |(_, name)| name.trim().to_owned())
}
