//! The surface area that each sample stands for: the integral of its basis function, the piecewise linear
//! (bilinear) function that is 1 at the sample and 0 at all others.

use super::LevelNumbering;

/// Mesh-space area of every sample at a level: a third, half or all of the hats of the faces around it.
/// The sum is the area of the mesh. All samples inside one strip, and inside one face, have the same.
pub struct SampleAreas {
    /// By fan.
    pub fans: Vec<f32>,
    /// By strip: each sample inside it.
    pub strips: Vec<f32>,
    /// By face: each sample inside it.
    pub faces: Vec<f32>,
}

impl SampleAreas {
    pub fn new(numbering: &LevelNumbering<'_>) -> Self {
        let topology = numbering.topology;
        let count = numbering.canvas.faces.len();
        let faces: Vec<f32> = (0..count).map(|face| inner_area(numbering, face)).collect();
        let mut fans = vec![0.0; topology.fan_count()];
        for ((canvas_face, area), corners) in numbering.canvas.faces.iter().zip(&faces).zip(&topology.fan_of)
        {
            let share = if canvas_face.is_triangle() { 1.0 / 6.0 } else { 0.25 };
            corners[..canvas_face.count()].iter().for_each(|&fan| fans[fan as usize] += area * share);
        }
        let mut strips = Vec::with_capacity(topology.strips.len());
        for (number, strip) in topology.strips.iter().enumerate() {
            let mut inside = 0.0;
            for side in topology.sides(strip) {
                let face = side.face as usize;
                let along = numbering.shape(face).edge_segments(side.edge.into());
                let step = (along / numbering.strip_segments(number)) as f32;
                // A finer face's points between two samples count for both: a hat's sum is `step`, and half of
                // what is left of it beyond its top falls to the strip's end.
                let share = faces[face] * 0.5;
                inside += share * step;
                strip.fans.iter().for_each(|&fan| fans[fan as usize] += share * 0.5 * (step - 1.0));
            }
            strips.push(inside);
        }
        Self { fans, strips, faces }
    }

    /// The area of one sample.
    pub fn of(&self, numbering: &LevelNumbering<'_>, sample: usize) -> f32 {
        match numbering.place(sample) {
            SamplePlace::Fan(fan) => self.fans[fan],
            SamplePlace::Strip(strip) => self.strips[strip],
            SamplePlace::Face(face) => self.faces[face],
        }
    }
}

/// What a sample lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplePlace {
    Fan(usize),
    Strip(usize),
    Face(usize),
}

/// The area of each sample inside a face.
fn inner_area(numbering: &LevelNumbering<'_>, face: usize) -> f32 {
    numbering.canvas.faces[face].area / numbering.shape(face).square_count()
}
