//! Skinning weights after quantization: those of a vertex no longer add up to 1, as glTF wants of floats.

/// Sums further away are not the quantization's doing.
const OFF_MAX: f64 = 0.01;

/// Divides the weights of every vertex by their sum. `sets`: four floats for each vertex, in equal numbers.
pub fn normalize(sets: &mut [&mut Vec<u8>]) {
    let vertex_count = sets.iter().map(|set| set.len() / 16).min().unwrap_or(0);
    for vertex in 0..vertex_count {
        let place = 16 * vertex..16 * vertex + 16;
        let read = |four: &[u8]| f64::from(f32::from_le_bytes([four[0], four[1], four[2], four[3]]));
        let sum: f64 = sets.iter().flat_map(|set| set[place.clone()].chunks_exact(4)).map(read).sum();
        if sum == 1.0 || (sum - 1.0).abs() > OFF_MAX || !sum.is_finite() {
            continue;
        }
        for four in sets.iter_mut().flat_map(|set| set[place.clone()].chunks_exact_mut(4)) {
            let weight = (read(four) / sum) as f32;
            four.copy_from_slice(&weight.to_le_bytes());
        }
    }
}
