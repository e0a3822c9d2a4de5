use meshcolor::{pipeline::*, read::*, watch::*};
use std::time::Instant;
struct W(std::sync::Mutex<(Instant, String)>);
impl Watch for W {
    fn stage(&self, s: Stage) {
        self.mark(s.name());
    }
    fn step(&self, s: Option<&'static str>) {
        if let Some(s) = s { self.mark(s) } else { self.mark("-") }
    }
}
impl W {
    fn mark(&self, n: &str) {
        let mut g = self.0.lock().unwrap();
        let e = g.0.elapsed();
        if e.as_millis() > 30 {
            eprintln!("{:>12} {:?}", g.1, e);
        }
        *g = (Instant::now(), n.to_string());
    }
}
struct Dir(std::path::PathBuf);
impl Files for Dir {
    fn read(&self, p: &str) -> meshcolor::Result<Option<Vec<u8>>> {
        Ok(std::fs::read(self.0.join(p)).ok())
    }
    fn names(&self) -> Vec<String> {
        vec![]
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let p = std::path::Path::new(&a[1]);
    let up = Upload {
        main: p.file_name().unwrap().to_str().unwrap().into(),
        files: Box::new(Dir(p.parent().unwrap().into())),
    };
    let mut o = Options::default();
    for kv in &a[3..] {
        let (k, v) = kv.split_once('=').unwrap();
        o.set(k, v).unwrap();
    }
    let w = W(std::sync::Mutex::new((Instant::now(), "start".into())));
    let c = match convert(&up, &o, &Limits::default(), &w) {
        Ok(c) => c,
        Err(e) => {
            eprintln!("ERR {e:?}");
            return;
        }
    };
    w.mark("end");
    std::fs::create_dir_all(&a[2]).unwrap();
    for f in &c.files {
        std::fs::write(format!("{}/{}", a[2], f.path), &f.bytes).unwrap();
    }
    for t in &c.finished.textures {
        for (l, i) in t.levels.iter().enumerate() {
            std::fs::write(
                format!("{}/{}_{l}.png", a[2], t.slots[0].gltf_name()),
                meshcolor::write::png(i).unwrap(),
            )
            .unwrap();
        }
    }
    println!("{:?} {:?}", c.report.verdict, c.report.errors);
    for w in &c.report.warnings {
        println!("W {:?}", w);
    }
    for ch in &c.report.channels {
        println!("{:?} cuts {:?} fid {:?}", ch.slots, ch.cuts, ch.fidelity);
        for l in &ch.levels {
            println!(
                "  {} {:?} seams {:?} drift {:?} | src {:?}",
                l.level,
                l.size,
                l.seams.map(|s| (s.max, s.p999, s.mean)),
                l.drift,
                l.source.map(|s| (s.seams.map(|f| f.mean), s.drift))
            );
        }
        for s in &ch.solver {
            println!("  {s:?}");
        }
    }
    for l in &c.report.layouts {
        println!(
            "{} faces q {} m {} l {} exps {:?}",
            l.face_count, l.quad_count, l.merged_pair_count, l.lone_triangle_count, l.exponents
        );
        for v in &l.levels {
            println!("  {v:?}");
        }
    }
    println!("{:?}", c.report.growth);
    for e in &c.report.effects {
        println!("{e:?}");
    }
}
