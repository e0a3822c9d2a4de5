//! The surface area that each sample stands for.

use super::LevelNumbering;

/// Mesh-space area of every sample at a level: a third, half or all of the hats of the faces around it.
/// The sum is the area of the mesh.
pub fn sample_areas(numbering: &LevelNumbering<'_>) -> Vec<f32> {
    let canvas = numbering.canvas;
    let mut areas = vec![0.0; numbering.sample_count()];
    let cell = |face: usize| canvas.faces[face].area / (numbering.segments(face) as f32).powi(2);
    let topology = numbering.topology;
    for (face, canvas_face) in canvas.faces.iter().enumerate() {
        let (corner, inner) = if canvas_face.is_triangle() { (1.0 / 3.0, 2.0) } else { (0.25, 1.0) };
        let n = numbering.segments(face);
        for edge in 0..canvas_face.count() {
            areas[topology.fan_of[face][edge] as usize] += cell(face) * corner;
            for along in 1..n {
                let tap = numbering.edge_tap(face, edge, along);
                let share = cell(face) * 0.5 * inner;
                areas[tap.samples[0] as usize] += share * (1.0 - tap.second);
                areas[tap.samples[1] as usize] += share * tap.second;
            }
        }
        areas[numbering.face_range(face)].fill(cell(face) * inner);
    }
    areas
}
