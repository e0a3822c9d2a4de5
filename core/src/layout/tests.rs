use std::collections::HashSet;

use glam::Vec3;

use super::{BlockKind, Layout, LayoutRequest, arrange, pair_triangles};
use crate::colors::Resolutions;
use crate::error::ErrorCode;
use crate::mesh::{CanvasMesh, Polygons, build};

/// A strip of `count` triangles, or of squares where `quads`.
fn strip(count: u32, quads: bool) -> CanvasMesh {
    let positions: Vec<Vec3> =
        (0..2 * count + 4).map(|k| Vec3::new((k / 2) as f32, (k % 2) as f32, 0.0)).collect();
    let mut faces = (0..count).map(|k| {
        if quads {
            ([2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1], 4)
        } else if k % 2 == 0 {
            ([k, k + 2, k + 1, 0], 3)
        } else {
            ([k, k + 1, k + 2, 0], 3)
        }
    });
    build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces }])
}

fn layout(
    canvas: &CanvasMesh,
    exponents: Vec<u8>,
    mergeable: bool,
    side_limit: u32,
) -> crate::Result<Layout> {
    let resolutions = Resolutions { faces: exponents };
    arrange(&LayoutRequest {
        canvas,
        resolutions: &resolutions,
        mergeable: &vec![mergeable; canvas.edges.len()],
        diagonals: &vec![1; canvas.faces.len()],
        level_count: usize::from(resolutions.max()) + 1,
        side_limit,
    })
}

#[test]
fn a_strip_pairs_without_a_rest() {
    let canvas = strip(10, false);
    let resolutions = Resolutions { faces: vec![2; 10] };
    let partners = pair_triangles(&canvas, &resolutions, &vec![true; canvas.edges.len()]);
    assert!(partners.iter().all(Option::is_some));
    for (face, partner) in partners.iter().enumerate() {
        assert_eq!(partners[partner.unwrap() as usize], Some(face as u32));
    }
    let mixed = Resolutions { faces: (0..10).map(|k| k % 2).collect() };
    assert!(pair_triangles(&canvas, &mixed, &vec![true; canvas.edges.len()]).iter().all(Option::is_none));
    let cut = pair_triangles(&canvas, &resolutions, &vec![false; canvas.edges.len()]);
    assert!(cut.iter().all(Option::is_none));
}

/// No texel belongs to two blocks at any level, and every block lies inside the image.
#[test]
fn blocks_never_meet() {
    for (quads, mergeable) in [(true, false), (false, true), (false, false)] {
        let canvas = strip(60, quads);
        let layout =
            layout(&canvas, (0..60u32).map(|k| (k * 7 % 5) as u8).collect(), mergeable, 4096).unwrap();
        for (level, size) in layout.sizes.iter().enumerate() {
            let mut taken = HashSet::new();
            for block in &layout.blocks {
                let first = block.corner(level).floor();
                let end = block.end(level);
                assert!(end[0] <= size[0] && end[1] <= size[1]);
                for y in first.y as u32..end[1] {
                    for x in first.x as u32..end[0] {
                        assert!(taken.insert((x, y)), "level {level}: texel {x}, {y} belongs to two blocks");
                    }
                }
            }
        }
    }
}

/// Invariant 4: `u_s` is a multiple of the face's side, `u_δ` an integer and a half.
#[test]
fn samples_stand_on_texel_centers() {
    let canvas = strip(50, false);
    let exponents: Vec<u8> = (0..50u32).map(|k| (k * 3 % 4) as u8).collect();
    let layout = layout(&canvas, exponents.clone(), true, 4096).unwrap();
    for (face, exponent) in exponents.iter().enumerate() {
        let side = f32::from(1u16 << exponent);
        assert_eq!(layout.offset(face).fract().to_array(), [0.5, 0.5]);
        let corners: Vec<_> = (0..3).map(|corner| layout.scaled(face, corner)).collect();
        for corner in &corners {
            assert_eq!((*corner % side).to_array(), [0.0, 0.0]);
        }
        let doubled_area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]).abs();
        assert_eq!(doubled_area, side * side, "a triangle is half its square");
    }
}

/// The two triangles of a merged pair put their shared vertices on the same texels.
#[test]
fn merged_triangles_meet_on_their_diagonal() {
    let canvas = strip(8, false);
    let layout = layout(&canvas, vec![3; 8], true, 4096).unwrap();
    let mut pairs = 0;
    for block in &layout.blocks {
        let BlockKind::Merged([first, second]) = block.kind else { continue };
        pairs += 1;
        let place = |face: u32, vertex: u32| {
            let face = face as usize;
            let corner = canvas.faces[face].vertices[..3].iter().position(|v| *v == vertex)?;
            Some((layout.scaled(face, corner), layout.offset(face)))
        };
        let vertices = canvas.faces[first as usize].vertices;
        let shared: Vec<_> = vertices[..3].iter().filter(|v| place(second, **v).is_some()).collect();
        assert_eq!(shared.len(), 2);
        for vertex in shared {
            assert_eq!(place(first, *vertex), place(second, *vertex));
        }
    }
    assert_eq!(pairs, 4);
}

#[test]
fn a_layout_over_the_limit_says_how_to_mend_it() {
    let canvas = strip(100, true);
    let error = layout(&canvas, vec![8; 100], false, 1024).unwrap_err();
    assert_eq!(error.code, ErrorCode::TextureTooLarge);
    assert!(error.detail.contains("--resolution"), "{}", error.detail);
    assert_eq!(error.limit, Some(1024));
}
