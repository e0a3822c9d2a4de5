//! Which pictures the sheet has: the whole asset, then the worst seam at forced levels.

use glam::DVec3;
use meshcolor::asset::Slot;
use meshcolor::pipeline::Focus;

use super::camera::{Camera, CloseUp, extent, fit, three_quarter};
use super::contrast::most_varied;
use super::geometry::Turn;
use super::surface::{Look, base_of};
use super::{Filter, Scene, Subject};

/// A camera with its subject; both sides are drawn from it.
pub struct View {
    pub subject: Subject,
    pub camera: Camera,
    pub size: [u32; 2],
    pub look: Look,
    pub filters: Vec<Filter>,
    /// Where the seam lies in the picture, pixels, if it faces the camera.
    pub mark: Option<[f32; 2]>,
}

/// Width of a picture on the sheet, pixels.
pub const PICTURE_WIDTH: u32 = 486;
const WHOLE_HEIGHTS: [u32; 2] = [340, 520];
const CLOSE_UP_HEIGHT: u32 = 300;

/// A close-up is this many edge lengths high, or this many texels of level 0 where those are more: what
/// a coarse level does cannot be seen on a short edge.
const FRAME_EDGES: f64 = 5.0;
const FRAME_TEXELS: f64 = 72.0;
/// The same for a triangle that is looked at as a whole, in its shortest edges.
const FRAME_EDGES_OF_TRIANGLE: f64 = 2.0;

/// The whole asset, three quarters, from the side on which the seam is if there is one.
pub fn whole(scene: &Scene<'_>, focus: Option<&Focus>) -> View {
    let world_normal = focus.and_then(|focus| {
        let to_world = scene.first_instance(focus.mesh)?;
        Some(Turn::new(to_world.matrix3).normal(focus.normal))
    });
    let right = world_normal.is_none_or(|normal| normal.x >= 0.0);
    let turn = three_quarter(right);
    let each = |visit: &mut dyn FnMut(DVec3)| scene.each_world_point(visit);
    let box_aspect = extent(turn, &each).map_or(1.0, |[low, high]| {
        let size = high - low;
        if size.y > 0.0 && size.x > 0.0 { size.x / size.y } else { 1.0 }
    });
    let height = (f64::from(PICTURE_WIDTH) / box_aspect).round();
    let height = (height as u32).clamp(WHOLE_HEIGHTS[0], WHOLE_HEIGHTS[1]);
    let camera = fit(turn, &each, f64::from(PICTURE_WIDTH) / f64::from(height));
    View {
        subject: Subject::World,
        camera,
        size: [PICTURE_WIDTH, height],
        look: Look::Lit,
        filters: vec![Filter::Trilinear],
        mark: focus.and_then(|focus| mark(scene, focus, &camera, [PICTURE_WIDTH, height])),
    }
}

/// The focus in a picture of the world, on the first instance of its mesh.
fn mark(scene: &Scene<'_>, focus: &Focus, camera: &Camera, size: [u32; 2]) -> Option<[f32; 2]> {
    let to_view = camera.to_view * scene.first_instance(focus.mesh)?;
    let position = to_view.transform_point3(focus.position.as_dvec3());
    let normal = Turn::new(to_view.matrix3).normal(focus.normal).as_dvec3();
    let is_facing = normal.dot(position.normalize_or_zero()) < -0.05;
    let clip = camera.projection.as_dmat4() * position.extend(1.0);
    let [x, y] = [0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w];
    let is_inside = (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
    (is_facing && is_inside).then_some([(x * f64::from(size[0])) as f32, (y * f64::from(size[1])) as f32])
}

/// The surroundings of the worst seam, one channel unlit, at up to three levels. `None` where the focus
/// points past the conversion.
pub fn close_up(scene: &Scene<'_>, focus: &Focus) -> Option<View> {
    framed(scene, focus, FRAME_EDGES)
}

fn framed(scene: &Scene<'_>, focus: &Focus, frame_edges: f64) -> Option<View> {
    let texture = scene.finished().textures.get(focus.texture)?;
    let slot = texture.slots.first().copied().unwrap_or(Slot::BaseColor);
    let is_shown = |&own: &usize| base_of(scene.asset(), scene.finished(), own) == slot;
    if slot.is_attribute() && !texture.materials.iter().any(is_shown) {
        return None;
    }
    scene.asset().meshes.get(focus.mesh)?.primitives.get(focus.primitive)?;
    let aspect = f64::from(PICTURE_WIDTH) / f64::from(CLOSE_UP_HEIGHT);
    let close_up = CloseUp {
        position: focus.position.as_dvec3(),
        normal: focus.normal.as_dvec3(),
        seam: seam_direction(focus),
        half_height: half_height(scene, focus, frame_edges),
        aspect,
    };
    Some(View {
        subject: Subject::Mesh { mesh: focus.mesh, keep: close_up.keep() },
        camera: close_up.camera(),
        size: [PICTURE_WIDTH, CLOSE_UP_HEIGHT],
        look: Look::Flat(slot),
        filters: forced_levels(texture.levels.len()).into_iter().map(Filter::Level).collect(),
        mark: Some([PICTURE_WIDTH as f32 / 2.0, CLOSE_UP_HEIGHT as f32 / 2.0]),
    })
}

/// The same without a seam, for a source with mesh colors: where these vary most. `None` where it has none that vary.
pub fn painted_close_up(scene: &Scene<'_>) -> Option<View> {
    let view = framed(scene, &most_varied(scene)?, FRAME_EDGES_OF_TRIANGLE)?;
    Some(View { mark: None, ..view })
}

/// Along the edge, upwards in the world where it can be.
fn seam_direction(focus: &Focus) -> DVec3 {
    let along = focus.ends[1].as_dvec3() - focus.ends[0].as_dvec3();
    let along = along.try_normalize().unwrap_or(DVec3::Y);
    if along.y < 0.0 { -along } else { along }
}

/// Levels 2 and 4 and the last but one, as far as there are.
fn forced_levels(level_count: usize) -> Vec<u32> {
    let last = level_count.saturating_sub(1);
    let mut levels: Vec<usize> = [2, 4, level_count.saturating_sub(2)]
        .into_iter()
        .filter(|level| (1..=last).contains(level))
        .collect();
    if levels.is_empty() {
        levels.push(last);
    }
    levels.sort_unstable();
    levels.dedup();
    levels.into_iter().map(|level| level as u32).collect()
}

fn half_height(scene: &Scene<'_>, focus: &Focus, frame_edges: f64) -> f64 {
    let edge_length = focus.ends[0].as_dvec3().distance(focus.ends[1].as_dvec3());
    let by_edge = edge_length * frame_edges / 2.0;
    let by_texels = texels_per_unit(scene, focus).map_or(0.0, |density| FRAME_TEXELS / density / 2.0);
    let positions = scene.asset().meshes[focus.mesh].primitives.iter().flat_map(|p| &p.positions);
    let (low, high) = positions.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), position| {
        (low.min(position.as_dvec3()), high.max(position.as_dvec3()))
    });
    let whole = (high - low).length() / 2.0;
    let wanted = by_edge.max(by_texels).min(whole);
    if wanted.is_finite() && wanted > 0.0 { wanted } else { 1.0 }
}

/// Texels of level 0 per unit of length around the focus: over the triangles that have one of its ends.
fn texels_per_unit(scene: &Scene<'_>, focus: &Focus) -> Option<f64> {
    let primitive = &scene.asset().meshes[focus.mesh].primitives[focus.primitive];
    let pieces = scene.finished().primitives.iter();
    let pieces = pieces.filter(|piece| (piece.mesh, piece.primitive) == (focus.mesh, focus.primitive));
    let (mut texels, mut length) = (0.0, 0.0);
    for (piece, triangle) in pieces.flat_map(|piece| piece.triangles.iter().map(move |t| (piece, t))) {
        let at = triangle.vertices.map(|vertex| primitive.positions[vertex as usize]);
        if !at.iter().any(|position| focus.ends.contains(position)) {
            continue;
        }
        let along = piece.coordinates.texels(triangle);
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            texels += f64::from(along[next].distance(along[corner]));
            length += at[corner].as_dvec3().distance(at[next].as_dvec3());
        }
    }
    (texels > 0.0 && length > 0.0).then(|| texels / length)
}

#[cfg(test)]
mod tests {
    use super::forced_levels;

    #[test]
    fn levels_that_exist_are_forced() {
        assert_eq!(forced_levels(8), vec![2, 4, 6]);
        assert_eq!(forced_levels(6), vec![2, 4]);
        assert_eq!(forced_levels(5), vec![2, 3, 4]);
        assert_eq!(forced_levels(3), vec![1, 2]);
        assert_eq!(forced_levels(2), vec![1]);
        assert_eq!(forced_levels(1), vec![0]);
        assert_eq!(forced_levels(0), vec![0]);
    }
}
