use super::*;

/// The square [0, 1]² in the plane z = 0, image upright on it: u to the right, v down.
fn upright_square() -> Primitive {
    Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        texcoords: vec![vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::ZERO]],
        faces: vec![Face::quad([0, 1, 2, 3])],
        ..Primitive::default()
    }
}

fn assert_sound(frames: &[[Frame; 4]]) {
    for frame in frames.iter().flatten() {
        assert!((frame.normal.length() - 1.0).abs() < 1e-5, "{frame:?}");
        assert!((frame.tangent.truncate().length() - 1.0).abs() < 1e-5, "{frame:?}");
        assert!(frame.tangent.w.abs() == 1.0, "{frame:?}");
        assert!(frame.normal.dot(frame.tangent.truncate()).abs() < 1.0 - 1e-7, "{frame:?}");
    }
}

#[test]
fn green_points_up_in_the_image() {
    for frame in frames(&upright_square(), 0, UvTransform::default())[0] {
        let bitangent = frame.normal.cross(frame.tangent.truncate()) * frame.tangent.w;
        assert!(frame.normal.distance(Vec3::Z) < 1e-6);
        assert!(frame.tangent.truncate().distance(Vec3::X) < 1e-6);
        assert!(bitangent.distance(Vec3::Y) < 1e-6);
    }
}

#[test]
fn a_mirrored_image_changes_the_handedness() {
    let mut square = upright_square();
    square.texcoords[0].iter_mut().for_each(|uv| uv.x = -uv.x);
    let frame = frames(&square, 0, UvTransform::default())[0][0];
    assert!(frame.tangent.truncate().distance(-Vec3::X) < 1e-6);
    assert_eq!(frame.tangent.w, -1.0);
}

#[test]
fn a_texture_transform_turns_the_tangent() {
    let quarter = UvTransform { rotation: std::f32::consts::FRAC_PI_2, ..UvTransform::default() };
    let frame = frames(&upright_square(), 0, quarter)[0][0];
    assert!(frame.tangent.x.abs() < 1e-6 && frame.tangent.y.abs() > 0.999, "{frame:?}");
}

#[test]
fn stored_tangents_count_only_beside_stored_normals() {
    let mut square = upright_square();
    square.tangents = vec![Vec4::new(0.0, 1.0, 0.0, -1.0); 4];
    assert!(frames(&square, 0, UvTransform::default())[0][0].tangent.x > 0.999);
    square.normals = vec![Vec3::Z; 4];
    assert_eq!(frames(&square, 0, UvTransform::default())[0][0].tangent, square.tangents[0]);
}

#[test]
fn degenerate_faces_and_coordinates_have_frames_too() {
    let mut square = upright_square();
    square.faces = vec![
        Face::quad([0, 1, 2, 2]),
        Face::quad([0, 1, 0, 3]),
        Face::triangle([1, 1, 1]),
        Face::triangle([0, 1, 1]),
        Face::triangle([0, 1, 2]),
    ];
    let frames_here = frames(&square, 0, UvTransform::default());
    assert_sound(&frames_here);
    assert_eq!(frames_here[0][3], frames_here[0][2]);
    assert_sound(&frames(&square, 7, UvTransform::default()));
    square.positions.iter_mut().for_each(|p| *p *= 1e-30);
    assert_sound(&frames(&square, 0, UvTransform::default()));
    square.positions.iter_mut().for_each(|p| *p *= 1e38);
    square.positions.iter_mut().for_each(|p| *p *= 1e30);
    assert_sound(&frames(&square, 0, UvTransform::default()));
    square.texcoords[0] = vec![Vec2::splat(0.25); 4];
    assert_sound(&frames(&square, 0, UvTransform::default()));
}

#[test]
fn the_own_tangents_of_a_crowded_fan_are_those_of_mikktspace() {
    let fan = |count: u32| {
        let rim = |i: u32| Vec2::from_angle(i as f32 * std::f32::consts::TAU / count as f32);
        let mut positions = vec![Vec3::ZERO];
        positions.extend((0..count).map(|i| rim(i).extend(0.0)));
        Primitive {
            texcoords: vec![positions.iter().map(|p| Vec2::new(p.x, -p.y)).collect()],
            faces: (0..count).map(|i| Face::triangle([0, 1 + i, 1 + (i + 1) % count])).collect(),
            positions,
            ..Primitive::default()
        }
    };
    for count in [FAN_LIMIT, FAN_LIMIT + 1, 20_000] {
        let frames = frames(&fan(count), 0, UvTransform::default());
        assert_sound(&frames);
        assert!(frames.iter().flatten().all(|frame| frame.tangent.truncate().distance(Vec3::X) < 1e-2));
        assert!(frames.iter().flatten().all(|frame| frame.tangent.w == 1.0));
    }
}
