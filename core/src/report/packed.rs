//! Numbers one after the other, as files and pages have them.

use nalgebra::Vector3;

/// The components of `vectors`, three each.
pub fn components(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| [vector.x, vector.y, vector.z]).collect()
}

/// `numbers` as little-endian f64.
pub fn double(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// `numbers` as little-endian i64.
pub fn whole(numbers: &[usize]) -> Vec<u8> {
    numbers.iter().flat_map(|number| (*number as i64).to_le_bytes()).collect()
}
