//! Where to look closer at a source with mesh colors, which has no seams of its own: the triangle on which they vary most for
//! its size.

use glam::{DVec3, Vec2, Vec3, Vec4};
use meshcolor::asset::{Primitive, Slot};
use meshcolor::math::transfer::linear_to_srgb;
use meshcolor::pipeline::Focus;
use meshcolor::source::painted::PaintedChannel;

use super::Scene;
use super::painted::source_of;
use super::surface::base_of;

/// Colors are compared at this level: what varies only in finer ones is gone in the pictures of coarse levels.
const LEVEL: usize = 2;

/// `None` where no mesh color is anything but a normal, or the source has none.
pub fn most_varied(scene: &Scene<'_>) -> Option<Focus> {
    let mut best: Option<(f64, Focus)> = None;
    for (mesh, content) in scene.asset().meshes.iter().enumerate() {
        for (number, primitive) in content.primitives.iter().enumerate() {
            each_spot(scene, [mesh, number], primitive, &mut |score, focus| {
                if best.is_none_or(|(most, _)| score > most) {
                    best = Some((score, focus));
                }
            });
        }
    }
    best.map(|(_, focus)| focus)
}

/// Visits every drawn triangle of a primitive on which mesh colors vary, with what it scores.
fn each_spot(
    scene: &Scene<'_>,
    [mesh, number]: [usize; 2],
    primitive: &Primitive,
    visit: &mut dyn FnMut(f64, Focus),
) {
    let Some(source) = source_of(scene.painted, primitive.material) else { return };
    let base = base_of(scene.asset(), scene.finished(), source.material);
    let mut slots = [base].into_iter().chain(Slot::CORE).filter(|slot| *slot != Slot::Normal);
    let Some((slot, channel)) = slots.find_map(|slot| Some((slot, source.channel(slot)?))) else { return };
    let mut textures = scene.finished().textures.iter();
    let texture =
        textures.position(|own| own.materials.contains(&source.material) && own.slots.contains(&slot));
    let Some(texture) = texture else { return };
    for (face_number, face) in primitive.faces.iter().enumerate() {
        for corners in face.triangles() {
            let Some(place) = source.place([mesh, number, face_number], *corners) else { continue };
            let [a, b, c] =
                corners.map(|corner| primitive.positions[face.corners[corner] as usize].as_dvec3());
            let cross = (b - a).cross(c - a);
            let codes = |weights: Vec3| shown_codes(channel, slot, place.face as usize, place.at(weights));
            let points = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(1.0 / 3.0)].map(codes);
            let most = points.into_iter().fold(Vec4::MIN, Vec4::max);
            let least = points.into_iter().fold(Vec4::MAX, Vec4::min);
            let score = f64::from((most - least).max_element()) * cross.length().sqrt();
            if score.is_finite() && score > 0.0 {
                let focus = Focus {
                    mesh,
                    primitive: number,
                    position: ((a + b + c) / 3.0).as_vec3(),
                    ends: shortest_edge([a, b, c]).map(|end| end.as_vec3()),
                    normal: cross.normalize_or_zero().as_vec3(),
                    texture,
                    source_jumps_codes: [0.0; 8],
                };
                visit(score, focus);
            }
        }
    }
}

/// What the picture's frame is measured by.
fn shortest_edge([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    let edges = [[a, b], [b, c], [c, a]];
    let shorter = |one: [DVec3; 2], other: [DVec3; 2]| {
        if other[0].distance(other[1]) < one[0].distance(one[1]) { other } else { one }
    };
    edges.into_iter().fold([a, b], shorter)
}

/// Of color as a picture stores it; alpha is left out.
fn shown_codes(channel: &PaintedChannel<'_>, slot: Slot, face: usize, at: Vec2) -> Vec4 {
    let value = channel.colors.linear(face, at, LEVEL).with_w(0.0);
    if slot.is_color() { value.map(linear_to_srgb) * 255.0 } else { value * 255.0 }
}
