//! tumblenet
pub mod assets;
pub mod geometry;
pub mod problems;
pub mod quantity;
pub mod read;
pub mod net {
    pub mod spec;
}
pub mod solver;
pub mod target;
pub mod effects {
    #[derive(
        Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
    )]
    pub struct Effects {}
}
pub mod scene {
    pub mod schema;
}
pub mod report {
    pub mod replay;
}
