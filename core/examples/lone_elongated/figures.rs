//! What is printed: means, what 99 % keep to, the largest.

use glam::DVec3;

#[derive(Default)]
pub struct Figures(Vec<f64>);

impl Figures {
    /// Of the components that count.
    pub fn add(&mut self, values: DVec3, component_count: usize) {
        self.0.extend(values.abs().to_array().iter().take(component_count));
    }

    /// `mean, p99, most`; a dash where there is nothing.
    pub fn text(&mut self) -> String {
        self.0.sort_by(f64::total_cmp);
        let Some(most) = self.0.last() else { return "–".to_owned() };
        let mean = self.0.iter().sum::<f64>() / self.0.len() as f64;
        let p99 = self.0[(self.0.len() - 1) * 99 / 100];
        format!("{mean:.2}, {p99:.1}, {most:.0}")
    }

    /// Above `bound`, of all.
    pub fn share_above(&self, bound: f64) -> String {
        let above = self.0.iter().filter(|value| **value > bound).count();
        if self.0.is_empty() { "–".to_owned() } else { percent(above as f64, self.0.len() as f64) }
    }
}

pub fn percent(part: f64, whole: f64) -> String {
    format!("{:.2}", 100.0 * part / whole.max(f64::MIN_POSITIVE))
}

/// A squared error of codes as PSNR.
pub fn decibels(squared: f64) -> String {
    format!("{:.1}", 10.0 * (255.0 * 255.0 / squared).log10())
}
