//! What of reports goes over every knot of every frame; all else of them is in `tumblenet`.

pub mod packed;
pub mod replay;
