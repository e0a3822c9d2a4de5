use super::*;
use crate::asset::Slot;
use crate::measure::hand_made::{finished, image, source_surface, square, surface_of};

#[test]
fn an_edge_of_many_faces_counts_once() {
    let mut asset = square(Slot::BaseColor, image([4, 4], |_, _| [0; 3]));
    let primitive = &mut asset.meshes[0].primitives[0];
    primitive.faces.push(primitive.faces[1]);
    primitive.faces.push(primitive.faces[1]);
    let surface = source_surface(&asset);
    // The diagonal with four faces, and two other edges of three equal triangles with two pairs each.
    assert_eq!(surface.pairs.len(), 3 + 2 + 2);
    let diagonal: Vec<u32> = (0..7).filter(|&pair| surface.pairs[pair as usize].a.triangle == 0).collect();
    let mut cut_flags = vec![false; 7];
    cut_flags[diagonal[2] as usize] = true;
    let share = cut_share(&surface, &diagonal, &cut_flags);
    assert_eq!((share.seam_edge_count, share.cut_edge_count), (1, 1));
    assert_eq!((share.cut_share, share.welded_share), (1.0, 0.0));
    let diagonal_length = 2.0f64.sqrt();
    assert!((share.seam_share - diagonal_length / (diagonal_length + 2.0)).abs() < 1e-6);
    assert_eq!(uncut(&cut_flags).len(), 6);
}

#[test]
fn triangles_that_read_the_same_texels_have_no_jump() {
    let asset = square(Slot::Occlusion, image([4, 4], |_, _| [0; 3]));
    let mut twins = finished(Slot::Occlusion, |at| [(at.x * 200.0) as u8, (at.y * 200.0) as u8, 7]);
    let first = twins.primitives[0].triangles[0];
    twins.primitives[0].triangles[1].corners = first.corners;
    twins.primitives[0].triangles[1].corners.swap(1, 2);
    twins.primitives[0].triangles[1].anchor = first.anchor;
    let surface = surface_of(&asset, &twins);
    let converted = Converted::new(&surface, vec![&twins.textures[0]], Meaning::Data).unwrap();
    // Vertices 5, 4, 3: the diagonal runs from its second corner to its third.
    assert!(converted.survey(0, &[0]).figures.max < 1e-3);
    twins.primitives[0].triangles[1].corners.swap(1, 2);
    let surface = surface_of(&asset, &twins);
    let converted = Converted::new(&surface, vec![&twins.textures[0]], Meaning::Data).unwrap();
    assert!((converted.survey(0, &[0]).figures.max - 200.0).abs() < 1e-3);
}
