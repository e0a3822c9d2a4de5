use super::*;

#[test]
fn what_is_left_of_a_model_shows_what_it_showed() {
    for seed in 0..20 {
        let asset = painted_box(seed);
        let before = painting(&asset);
        // A quad, and a triangle that is alone.
        let selection = Selection { material: None, faces: Some(vec![[1, 1], [6, 6]]) };
        let edited = delete(&asset, &selection, &Limits::default(), &Unwatched).unwrap();
        assert_eq!(
            (edited.report.materials[0].face_count_before, edited.report.materials[0].face_count),
            (7, 5)
        );
        let after = painting(&reread(&edited));
        assert_eq!(after.resolutions.faces.len(), 5);
        let mut random = Random(seed);
        for (old, new) in before.channels.iter().zip(&after.channels) {
            for (face, old_face) in [0, 2, 3, 4, 5].into_iter().enumerate() {
                assert_eq!(after.resolutions.faces[face], before.resolutions.faces[old_face]);
                let places = places(&after, face, &mut random);
                let moved: Vec<_> = places.iter().map(|(_, at)| (old_face, *at)).collect();
                assert_near(&shown(&before, old, &moved), &shown(&after, new, &places), "deleted");
            }
        }
    }
}

#[test]
fn vertices_that_nobody_uses_go() {
    let asset = painted_box(0);
    let selection = Selection { material: None, faces: Some(vec![[1, 6]]) };
    let edited = delete(&asset, &selection, &Limits::default(), &Unwatched).unwrap();
    let after = reread(&edited);
    assert_eq!(after.meshes[0].primitives[0].positions.len(), 4);
    assert_eq!(after.meshes[0].primitives[0].normals[0], asset.meshes[0].primitives[0].normals[0]);
    let all = Selection::default();
    let error = delete(&asset, &all, &Limits::default(), &Unwatched).unwrap_err();
    assert!(error.detail.contains("mesh 0 would have no faces left"), "{}", error.detail);
}

/// By place: both models have the same shape.
#[test]
fn four_faces_show_what_one_showed() {
    for seed in 0..20 {
        let asset = painted_box(seed);
        let before = painting(&asset);
        let edited = subdivide(&asset, Scheme::Midpoint, &Limits::default(), &Unwatched).unwrap();
        let subdivided = reread(&edited);
        let after = painting(&subdivided);
        assert_eq!(after.canvas.faces.len(), 4 * before.canvas.faces.len());
        assert_eq!(after.canvas.pair_count(), 4 * before.canvas.pair_count());
        assert!(after.canvas.edges.iter().all(|edge| after.canvas.sides(edge).len() == 2), "it is closed");
        let [from, to] = [Side::new(&asset, &before.canvas), Side::new(&subdivided, &after.canvas)];
        let surface = Surface::new(&before.canvas, &from.positions);
        let mut random = Random(seed);
        for (old, new) in before.channels.iter().zip(&after.channels) {
            assert_kept(old, new, "subdivided");
            let was_cut = old.cuts.edges.iter().filter(|cut| **cut).count();
            assert_eq!(new.cuts.edges.iter().filter(|cut| **cut).count(), 2 * was_cut);
            for face in 0..after.canvas.faces.len() {
                // Not on an edge, where either of two faces may be found and a cut shows two things.
                let inside = |(face, at): (usize, Vec2)| (face, at * 0.8 + Vec2::splat(0.05));
                let places: Vec<_> = places(&after, face, &mut random).into_iter().map(inside).collect();
                let found: Vec<_> = (places.iter())
                    .map(|(face, at)| {
                        let point =
                            to.point(&super::super::side::Spot { face: *face as u32, at: at.to_array() });
                        let place = surface.nearest(&before.canvas, point).unwrap();
                        assert!(place.distance < 1e-6);
                        (place.face as usize, place.at)
                    })
                    .collect();
                for (before, after) in shown(&before, old, &found).iter().zip(shown(&after, new, &places)) {
                    assert!((*before - after).abs().max_element() < 2e-5, "seed {seed}: {before} {after}");
                }
            }
        }
    }
}

#[test]
fn cubes_become_catmull_and_clarks_and_octahedra_loops() {
    let cube = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32) * 2.0 - Vec3::ONE;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let moved = split_and_smooth((0..8).map(cube).collect(), quads.map(Face::quad).to_vec());
    // A corner: 1/n of the mean face point, 2/n of the mean edge middle, the rest of itself; n = 3.
    let wanted = Vec3::splat(-1.0 / 3.0) / 3.0 + Vec3::splat(-2.0 / 3.0) * 2.0 / 3.0;
    assert!((moved[0] - wanted).length() < 1e-6, "{}", moved[0]);
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let triangles = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let moved = split_and_smooth(axes.to_vec(), triangles.map(Face::triangle).to_vec());
    // Loop's weight of the ring for four neighbors, whose mean is 0; an edge: 3/8 of its ends, 1/8 of what is opposite.
    let ring = 0.625 - (0.375 + 0.25 * 0.0f32).powi(2);
    assert!((moved[0] - Vec3::X * (1.0 - ring)).length() < 1e-6, "{}", moved[0]);
    let middle = moved[6..].iter().find(|p| p.z == 0.0 && p.x > 0.0 && p.y > 0.0).unwrap();
    assert!((*middle - Vec3::new(0.375, 0.375, 0.0)).length() < 1e-6, "{middle}");
}

#[test]
fn borders_become_splines() {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
    let moved = split_and_smooth(square.to_vec(), vec![Face::quad([0, 1, 2, 3])]);
    // 3/4 of the corner and 1/8 of either neighbor.
    assert!((moved[0] - Vec3::new(0.125, 0.125, 0.0)).length() < 1e-6, "{}", moved[0]);
    assert!((moved[4] - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-6, "{}", moved[4]);
}

fn split_and_smooth(positions: Vec<Vec3>, faces: Vec<Face>) -> Vec<Vec3> {
    let primitive = Primitive { positions, faces, ..Primitive::default() };
    let primitive = super::super::split::split(&primitive, super::super::split::Center::Mean);
    let mut mesh = Mesh { name: String::new(), primitives: vec![primitive] };
    super::super::smooth::smooth(&mut mesh);
    mesh.primitives.remove(0).positions
}

#[test]
fn smooth_schemes_carry_the_same_samples() {
    let asset = painted_box(5);
    let flat =
        painting(&reread(&subdivide(&asset, Scheme::Midpoint, &Limits::default(), &Unwatched).unwrap()));
    let smooth = reread(&subdivide(&asset, Scheme::CatmullClark, &Limits::default(), &Unwatched).unwrap());
    let round = painting(&smooth);
    for (flat, round) in flat.channels.iter().zip(&round.channels) {
        assert_eq!(flat.values, round.values);
    }
    assert_ne!(flat.canvas.positions, round.canvas.positions);
    let normals = &smooth.meshes[0].primitives[0].normals;
    assert!(normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
}

#[test]
fn schemes_that_do_not_fit_are_refused() {
    let refused =
        |asset: &Asset, scheme| subdivide(asset, scheme, &Limits::default(), &Unwatched).unwrap_err();
    let asset = painted_box(0);
    assert!(refused(&asset, Scheme::Loop).detail.contains("has quads"));
    let mut skinned = asset.clone();
    let joints = Attribute {
        semantic: "JOINTS_0".into(),
        component_type: 5121,
        kind: "VEC4".into(),
        normalized: false,
        element_bytes: 4,
        bytes: vec![0; 32],
    };
    skinned.meshes[0].primitives[0].attributes.push(joints.clone());
    assert!(refused(&skinned, Scheme::Midpoint).detail.contains("skinned"));
    let mut morphed = asset.clone();
    let deltas = Attribute {
        semantic: "POSITION".into(),
        component_type: 5126,
        kind: "VEC3".into(),
        element_bytes: 12,
        bytes: vec![0; 96],
        ..joints
    };
    morphed.meshes[0].primitives[0].targets.push(MorphTarget { attributes: vec![deltas] });
    assert!(refused(&morphed, Scheme::CatmullClark).detail.contains("morph targets"));
    let kept = reread(&subdivide(&morphed, Scheme::Midpoint, &Limits::default(), &Unwatched).unwrap());
    let primitive = &kept.meshes[0].primitives[0];
    assert_eq!(primitive.targets[0].attributes[0].bytes.len(), 12 * primitive.positions.len());
    let limits = Limits { triangles: 40, ..Limits::default() };
    let error = subdivide(&asset, Scheme::Midpoint, &limits, &Unwatched).unwrap_err();
    assert_eq!((error.code, error.actual), (ErrorCode::TooManyTriangles, Some(48)));
}
