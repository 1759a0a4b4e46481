use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

#[test]
fn try_main() {
    let text = std::fs::read_to_string("/tmp/board/graph.txt").unwrap();
    let mut g = Graph { vertices: 0, strands: vec![], leaves_at: vec![] };
    for l in text.lines() {
        let v: Vec<f64> = l.split_whitespace().map(|x| x.parse().unwrap()).collect();
        g.strands.push(Strand { ends: [v[0] as usize, v[1] as usize], length: v[2], radius: v[3] / 2.0, bend: v[3] * 5.0 });
        g.leaves_at.push([v[4], v[5]]);
        g.vertices = g.vertices.max(v[0] as usize + 1).max(v[1] as usize + 1);
    }
    for board in [None, Some([6.0, 1.7]), Some([5.0,1.7]), Some([4.2, 1.7])] {
    let t = std::time::Instant::now();
    let l = lay_out(&g, &Room { gap: 0.005, board });
    println!("{:?}", t.elapsed());
    let Ok(l) = l else { println!("{l:?}"); continue };
    println!("{:?} {} {} {}", l.size, l.zone, l.straight, l.lines.iter().filter(|l| l.curvature != 0.0).count());
    let mut svg = format!("<svg xmlns='http://www.w3.org/2000/svg' viewBox='-0.05 -0.05 {} {}' width='1600' height='{}'><rect x='-1' y='-1' width='20' height='20' fill='white'/>", l.size[0]+0.1, l.size[1]+0.1, 1600.0*(l.size[1]+0.1)/(l.size[0]+0.1));
    for (line, s) in l.lines.iter().zip(&g.strands) {
        let pts: Vec<String> = (0..=20).map(|k| { let p = line.at(line.length * k as f64/20.0); format!("{},{}", p.x, l.size[1]-p.y) }).collect();
        svg += &format!("<polyline points='{}' fill='none' stroke='black' stroke-width='{}'/>", pts.join(" "), 2.0*s.radius);
    }
    std::fs::write(if board.is_some() {"/tmp/board/b.svg"} else {"/tmp/board/a.svg"}, svg + "</svg>").unwrap();
    }
}
