use super::{Candidates, Choice, spend};
use crate::colors::{Resolutions, Shape};
use crate::image::Image;
use crate::mesh::{CanvasMesh, merge};
use crate::resample::Rates;
use crate::resample::tests::{canvas_of, image, two_charts};
use crate::source::{SurfaceSource, channels};
use crate::watch::Unwatched;

/// The two triangles of [`two_charts`] over 12 by 12 texels of the picture, as one quad where they are a pair.
fn rates_of(picture: Image, is_pair: bool, finest: u8) -> (CanvasMesh, Rates) {
    let (low, high) = (0.125, 0.875);
    let asset =
        two_charts(picture, [[low, low], [high, low], [low, high]], [[high, high], [low, high], [high, low]]);
    let canvas = canvas_of(&asset);
    let channels = channels(&asset, 0, false);
    let source = SurfaceSource::new(&channels[0], &asset, &canvas);
    let merged = merge(&canvas, &if is_pair { [Some(1), Some(0)] } else { [None, None] });
    let source = source.merged(&merged);
    let resolutions = Resolutions::uniform(vec![finest; merged.canvas.faces.len()]);
    let rates = Rates::new(&merged.canvas, &[source], &resolutions, true, &Unwatched).unwrap();
    (merged.canvas, rates)
}

fn texels(shape: Shape) -> f64 {
    f64::from(shape.segments[0] + 1) * f64::from(shape.segments[1] + 1)
}

fn with<T>(canvas: &CanvasMesh, rates: &Rates, then: impl FnOnce(Candidates<'_>) -> T) -> T {
    then(Candidates { canvas, rates, texels: &texels })
}

fn noise(x: u32, y: u32) -> u8 {
    ((x * 7919 + y * 104_729 + x * y * 613) % 251) as u8
}

#[test]
fn what_is_flat_comes_down_to_its_corners() {
    for is_pair in [false, true] {
        let (canvas, rates) = rates_of(image(|_, _| 130), is_pair, 4);
        let coarse = with(&canvas, &rates, |candidates| candidates.within(0.01)).resolutions(&rates);
        assert!(coarse.faces.iter().all(|exponents| *exponents == [0, 0]), "{coarse:?}");
    }
}

#[test]
fn noise_stays_as_fine_as_it_can_be() {
    let (canvas, rates) = rates_of(image(noise), true, 4);
    assert_eq!(with(&canvas, &rates, |candidates| candidates.within(1.0)), Choice::finest(&rates));
}

/// Stripes need samples across them alone, whichever way they run.
#[test]
fn stripes_make_an_elongated_quad() {
    let mut found = Vec::new();
    for along_x in [false, true] {
        let stripes = image(|x, y| if (if along_x { y } else { x }) % 8 < 4 { 40 } else { 210 });
        let (canvas, rates) = rates_of(stripes, true, 4);
        found.push(with(&canvas, &rates, |candidates| candidates.within(30.0)).resolutions(&rates).faces[0]);
    }
    let [[r, s], other] = found[..] else { panic!("two") };
    assert!(r.min(s) == 0 && r.max(s) >= 3, "{found:?}");
    assert_eq!(other, [s, r]);
}

/// A picture of one half noise: more texels take away error, are never more than asked for, and go to the noise first.
#[test]
fn a_budget_goes_where_the_error_is() {
    let half = image(|x, y| if x + y < 16 { noise(x, y) } else { 90 });
    let (canvas, rates) = rates_of(half, false, 4);
    let finest = Choice::finest(&rates);
    let error = |choice: &Choice| -> f64 {
        let of_face = |(face, &taken): (usize, &u32)| -> f64 {
            rates.errors(face, taken as usize).map(|error| f64::from(error.mean_square)).sum()
        };
        choice.taken.iter().enumerate().map(of_face).sum()
    };
    let mut last = f64::INFINITY;
    for budget in [1.0, 40.0, 100.0, 300.0, 1e9] {
        let choice = with(&canvas, &rates, |own| spend(&[own], std::slice::from_ref(&finest), budget))
            .choices
            .remove(0);
        let exponents = choice.resolutions(&rates).faces;
        let spent: f64 = exponents.iter().map(|[r, _]| texels(Shape::triangle(1 << r))).sum();
        assert!(spent <= budget.max(2.0 * texels(Shape::triangle(1))), "{budget}: {exponents:?}");
        assert!(error(&choice) <= last, "{budget}");
        assert!(exponents[0] >= exponents[1], "{budget}: {exponents:?}");
        last = error(&choice);
    }
    assert_eq!(last, error(&finest));
}
