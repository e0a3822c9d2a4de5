//! The surface area that each sample stands for: the integral of its basis function, the piecewise linear
//! (bilinear) function that is 1 at the sample and 0 at all others.

use super::LevelNumbering;

/// Mesh-space area of every sample at a level: a third, half or all of the hats of the faces around it.
/// The sum is the area of the mesh.
pub fn sample_areas(numbering: &LevelNumbering<'_>) -> Vec<f32> {
    let mut areas = shared_areas(numbering);
    areas.resize(numbering.sample_count(), 0.0);
    for face in 0..numbering.canvas.faces.len() {
        areas[numbering.face_range(face)].fill(inner_area(numbering, face));
    }
    areas
}

/// [`sample_areas`] of the samples on vertices and edges alone.
pub fn shared_areas(numbering: &LevelNumbering<'_>) -> Vec<f32> {
    let mut areas = fan_areas(numbering);
    areas.resize(numbering.shared_count(), 0.0);
    for (face, canvas_face) in numbering.canvas.faces.iter().enumerate() {
        let share = inner_area(numbering, face) * 0.5;
        for edge in 0..canvas_face.count() {
            for along in 1..numbering.segments(face) {
                let tap = numbering.edge_tap(face, edge, along);
                areas[tap.samples[0] as usize] += share * (1.0 - tap.second);
                areas[tap.samples[1] as usize] += share * tap.second;
            }
        }
    }
    areas
}

/// What each vertex sample has at the corners of its faces. It is all of its area where no face around it is
/// finer than the edge between them.
fn fan_areas(numbering: &LevelNumbering<'_>) -> Vec<f32> {
    let topology = numbering.topology;
    let mut areas = vec![0.0; topology.fan_count()];
    for (face, canvas_face) in numbering.canvas.faces.iter().enumerate() {
        let share = if canvas_face.is_triangle() { 1.0 / 6.0 } else { 0.25 };
        for corner in 0..canvas_face.count() {
            areas[topology.fan_of[face][corner] as usize] += inner_area(numbering, face) * share;
        }
    }
    areas
}

/// The area of each sample inside a face.
pub fn inner_area(numbering: &LevelNumbering<'_>, face: usize) -> f32 {
    let canvas_face = &numbering.canvas.faces[face];
    let cells = if canvas_face.is_triangle() { 2.0 } else { 1.0 };
    cells * canvas_face.area / (numbering.segments(face) as f32).powi(2)
}
