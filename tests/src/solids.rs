//! Random models for the tests of transformations: closed and open, of parallelograms or triangles, with texture
//! coordinates that wrap, mirror, overlap or have nothing to do with each other.

use glam::{Mat3, Quat, Vec2, Vec3};

use crate::patches::{Corner, Patch, Random};

/// How texture coordinates of neighboring faces relate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// Go on over the surface, several times around the picture.
    Wrapped,
    /// Turn back at every second grid line.
    Mirrored,
    /// Every face shows the same part of the picture.
    Overlapping,
    /// Every face shows a part of its own, turned anyhow.
    Unrelated,
}

pub const MAPPINGS: [Mapping; 4] =
    [Mapping::Wrapped, Mapping::Mirrored, Mapping::Overlapping, Mapping::Unrelated];

/// What the faces are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Parallelograms whose texture coordinates are parallelograms too: either diagonal draws the same.
    Parallelograms,
    Triangles,
}

/// The grid points of a cube's side: an affine map from [0, side]² to space.
struct Plane {
    origin: Vec3,
    axes: [Vec3; 2],
}

/// A sheared box (`is_closed`) or one of its corners: three or six sides of `side²` cells each.
pub fn random_box(random: &mut Random, side: usize, is_closed: bool, kind: Kind, mapping: Mapping) -> Patch {
    let mut patch = Patch { positions: Vec::new(), faces: Vec::new() };
    let shear = Mat3::from_cols(
        Vec3::new(1.0, 0.2 * random.unit(), 0.0),
        Vec3::new(0.3 * random.unit(), 1.5, 0.0),
        Vec3::new(0.0, 0.4 * random.unit(), 0.8),
    );
    let n = side as f32;
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    let near = [[x, y], [y, z], [z, x]].map(|axes| Plane { origin: Vec3::ZERO, axes });
    let far = [[y, x, z], [z, y, x], [x, z, y]].map(|[a, b, up]| Plane { origin: up * n, axes: [a, b] });
    for plane in near.iter().chain(far.iter().filter(|_| is_closed)) {
        add_plane(&mut patch, random, plane, side, (kind, mapping));
    }
    // Sheared last, so that grid points where sides meet are equal to the bit before and after.
    patch.positions.iter_mut().for_each(|position| *position = shear * *position);
    patch
}

fn add_plane(
    patch: &mut Patch,
    random: &mut Random,
    plane: &Plane,
    side: usize,
    (kind, mapping): (Kind, Mapping),
) {
    let first = patch.positions.len() as u32;
    let row = side + 1;
    for (i, j) in (0..=side).flat_map(|j| (0..=side).map(move |i| (i, j))) {
        patch.positions.push(plane.origin + plane.axes[0] * i as f32 + plane.axes[1] * j as f32);
    }
    for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
        let part = Part::new(random, mapping);
        let corner = |[x, y]: [usize; 2]| -> Corner {
            (first + ((j + y) * row + i + x) as u32, part.place([i, j], [x, y]))
        };
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(corner);
        match kind {
            Kind::Parallelograms => patch.faces.push(corners.to_vec()),
            Kind::Triangles => {
                let turn = random.below(2);
                for triangle in [[0, 1, 2], [0, 2, 3]] {
                    patch.faces.push(triangle.map(|k| corners[(k + turn) % 4]).to_vec());
                }
            }
        }
    }
}

/// The piece of the picture that a cell shows.
struct Part {
    mapping: Mapping,
    origin: Vec2,
    axes: [Vec2; 2],
}

impl Part {
    fn new(random: &mut Random, mapping: Mapping) -> Self {
        let mut any = |scale: f32| (Vec2::new(random.unit(), random.unit()) - 0.5) * scale;
        Self { mapping, origin: any(4.0), axes: [any(1.0), any(1.0)] }
    }

    /// Of a corner of a cell.
    fn place(&self, cell: [usize; 2], corner: [usize; 2]) -> Vec2 {
        let at = Vec2::new((cell[0] + corner[0]) as f32, (cell[1] + corner[1]) as f32);
        let here = Vec2::new(corner[0] as f32, corner[1] as f32);
        match self.mapping {
            Mapping::Wrapped => at * Vec2::new(0.55, 0.45) - 0.7,
            Mapping::Mirrored => (at % 2.0 - 1.0).abs() * 0.6 + 0.1,
            Mapping::Overlapping => here * 0.5 + 0.25,
            Mapping::Unrelated => self.origin + self.axes[0] * here.x + self.axes[1] * here.y,
        }
    }
}

/// The same model somewhere else: turned by `turn`, then scaled, then moved.
pub fn moved(patch: &Patch, turn: Quat, scale: f32, shift: Vec3) -> Patch {
    let place = |&position: &Vec3| turn * position * scale + shift;
    Patch { positions: patch.positions.iter().map(place).collect(), faces: patch.faces.clone() }
}

/// A turn of any axis and angle.
pub fn random_turn(random: &mut Random) -> Quat {
    let mut part = || random.unit() - 0.5;
    Quat::from_xyzw(part(), part(), part(), 0.1 + part().abs()).normalize()
}

/// The same faces in another order, each beginning with another corner: `(old face, corners turned by)` by face.
pub fn shuffled(patch: &Patch, random: &mut Random) -> (Patch, Vec<(usize, usize)>) {
    let mut order: Vec<(usize, usize)> =
        patch.faces.iter().enumerate().map(|(face, corners)| (face, random.below(corners.len()))).collect();
    random.shuffle(&mut order);
    let turned = |&(face, turn): &(usize, usize)| {
        let mut corners = patch.faces[face].clone();
        corners.rotate_left(turn);
        corners
    };
    let faces = order.iter().map(turned).collect();
    (Patch { positions: patch.positions.clone(), faces }, order)
}
