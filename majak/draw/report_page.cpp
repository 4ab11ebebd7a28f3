// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/report_page.hpp"

namespace majak::draw {

std::string_view report_style() {
  return R"css(
:root{--page:#f6f7f9;--card:#fff;--ink:#1b2330;--soft:#5d6878;--rule:#dfe4ea;--after:#1769d2;
--before:#d9730d; --odometry:#8a94a3;--truth:#0a8f6a;--good:#149a63;--strained:#d99a00;
--poor:#d43a3a;--weak:#f0a400;--lost:#d43a3a;--ellipse:#7a3fd1}
@media(prefers-color-scheme:dark){:root{--page:#12161c;--card:#1a2029;--ink:#e4e9f0;--soft:#93a0b2;
--rule:#2c3542; --after:#5aa9ff;--before:#ffab5c;--odometry:#7f8b9c;--truth:#3fd6a6;--good:#3fce90;
--strained:#f2c14e;--poor:#ff6b6b; --weak:#ffc24d;--lost:#ff6b6b;--ellipse:#b794ff}.map .picture{
filter:invert(1) brightness(.92)}}*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);
font:15px/1.5 system-ui,-apple-system,"Segoe UI",sans-serif}
main{max-width:1060px;margin:0 auto;padding:28px 20px 60px}
h1{font-size:26px;margin:0 0 2px;letter-spacing:-.01em}h2{font-size:17px;margin:0 0 10px}
p{margin:0 0 8px}.soft{color:var(--soft)}.lead{font-size:16px;max-width:70ch;margin:8px 0 20px}
section{background:var(--card);border:1px solid var(--rule);border-radius:10px;padding:18px 20px;
margin:16px 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;margin:16px 0}
.tile{background:var(--card);border:1px solid var(--rule);border-radius:10px;padding:12px 14px}
.tile b{display:block;font-size:21px;font-weight:650;letter-spacing:-.01em;white-space:nowrap}
.tile span{color:var(--soft);font-size:13px}.tile i{display:block;font-style:normal}
svg{display:block;width:100%;height:auto}
svg text{fill:var(--soft);font-size:12px;font-family:inherit}
.map{max-height:82vh;border-radius:6px;background:#cdcdcd;touch-action:none;cursor:grab}
.map .picture{image-rendering:pixelated}@media(prefers-color-scheme:dark){.map{background:#2e2e2e}}
.line{fill:none;stroke-width:1.6;stroke-linecap:round;stroke-linejoin:round;
vector-effect:non-scaling-stroke}.line.after{stroke:var(--after)}.line.before{stroke:var(--before)}
.line.odometry{stroke:var(--odometry)}.line.truth{stroke:var(--truth)}
.line.weak{stroke:var(--weak);stroke-width:4;stroke-opacity:.75}
.line.lost{stroke:var(--lost);stroke-width:5}
.closure line{stroke-width:1.1;stroke-opacity:.8;vector-effect:non-scaling-stroke;
stroke-linecap:round}.closure.good line{stroke:var(--good)}
.closure.strained line{stroke:var(--strained)}.closure.poor line{stroke:var(--poor)}
.closure.rejected line{stroke:var(--odometry);stroke-dasharray:3 3}
.closure line.lit{stroke:#ff00aa;stroke-width:5;stroke-opacity:1}
.ellipses ellipse{fill:var(--ellipse);fill-opacity:.18;stroke:var(--ellipse);
vector-effect:non-scaling-stroke}.start{fill:var(--good);stroke:#fff}
.goal{fill:var(--poor);stroke:#fff}.start,.goal{vector-effect:non-scaling-stroke}
.scale path{stroke:var(--ink);stroke-width:3;vector-effect:non-scaling-stroke}
.scale text{fill:var(--ink);font-size:inherit}.map .scale text{font-size:unset}.hide{display:none}
.keys{display:flex;flex-wrap:wrap;gap:4px 16px;margin:10px 0 0;font-size:13px;color:var(--soft)}
.keys label{display:inline-flex;align-items:center;gap:6px;cursor:pointer}
.keys input{margin:0;accent-color:var(--after)}.keys+p{margin-top:8px;font-size:13px}
.swatch{display:inline-block;width:16px;height:4px;border-radius:2px;background:var(--c)}
button{font:inherit;font-size:13px;color:var(--soft); background:none;border:1px solid var(--rule);
border-radius:6px;padding:1px 9px;cursor:pointer}.chart{margin:6px 0 2px}
.chart .title{fill:var(--ink);font-weight:600}.chart .end{text-anchor:end}
.chart .mid{text-anchor:middle}.chart .rule{stroke:var(--rule);fill:none}
.chart .extent{fill:var(--after);opacity:.22}
.chart .mean{fill:none;stroke:var(--after);stroke-width:1.5;stroke-linejoin:round}
.chart rect.weak{fill:var(--weak);opacity:.28}.chart rect.lost{fill:var(--lost);opacity:.4}
ul{margin:0;padding-left:20px}li{margin:3px 0}
table{border-collapse:collapse;width:100%;font-size:13.5px;font-variant-numeric:tabular-nums}
th{text-align:right;color:var(--soft);font-weight:600;cursor:pointer;position:sticky;top:0;
background:var(--card)}td{text-align:right}
th,td{padding:4px 8px;border-bottom:1px solid var(--rule)}th.l,td.l{text-align:left}
tbody tr:hover{background:color-mix(in srgb,var(--after) 10%,transparent)}
.scroll{max-height:420px;overflow:auto}
.dot{display:inline-block;width:9px;height:9px;border-radius:50%;background:var(--c);
margin-right:6px}pre{overflow:auto;max-height:420px;font-size:12.5px;margin:8px 0 0}
summary{cursor:pointer;font-weight:600}footer{color:var(--soft);font-size:13px;margin-top:22px}
@media print{.keys input,button{display:none}.scroll{max-height:none}}
)css";
}

std::string_view report_script() {
  return R"js(
const map=document.getElementById('map'),home=map.getAttribute('viewBox');
for(const box of document.querySelectorAll('[data-layer]'))box.onchange=()=>{
  for(const e of map.querySelectorAll('.layer.'+box.dataset.layer))e.classList.toggle('hide',!box.checked)};
const view=()=>map.getAttribute('viewBox').split(' ').map(Number);
const set=v=>map.setAttribute('viewBox',v.map(x=>+x.toFixed(2)).join(' '));
const at=e=>{
  const p=new DOMPoint(e.clientX,e.clientY).matrixTransform(map.getScreenCTM().inverse());
  return[p.x,p.y]};
const zoom=(x,y,f)=>{const[a,b,w,h]=view();set([x-(x-a)*f,y-(y-b)*f,w*f,h*f])};
const middle=f=>{const[a,b,w,h]=view();zoom(a+w/2,b+h/2,f)};
map.addEventListener('wheel',e=>{
  if(!e.ctrlKey&&!e.metaKey)return;
  e.preventDefault();zoom(...at(e),e.deltaY>0?1.2:1/1.2)},{passive:false});
map.ondblclick=e=>zoom(...at(e),1/1.8);
document.getElementById('in').onclick=()=>middle(1/1.5);
document.getElementById('out').onclick=()=>middle(1.5);
document.getElementById('home').onclick=()=>map.setAttribute('viewBox',home);
let grip=null;
map.onpointerdown=e=>{grip=at(e);map.setPointerCapture(e.pointerId)};
map.onpointermove=e=>{
  if(!grip)return;
  const[x,y]=at(e),[a,b,w,h]=view();set([a-x+grip[0],b-y+grip[1],w,h])};
map.onpointerup=map.onpointercancel=()=>grip=null;
for(const row of document.querySelectorAll('tr[data-closure]')){
  const line=document.getElementById(row.dataset.closure);
  if(!line)continue;
  row.onmouseenter=()=>line.classList.add('lit');
  row.onmouseleave=()=>line.classList.remove('lit')}
for(const head of document.querySelectorAll('table.sort th'))head.onclick=()=>{
  const body=head.closest('table').tBodies[0],i=head.cellIndex;
  const sign=head.dataset.down==='1'?1:-1;
  head.dataset.down=sign<0?'1':'0';
  const key=r=>{const t=r.cells[i].textContent,n=parseFloat(t);return isNaN(n)?t:n};
  const order=(a,b)=>{const p=key(a),q=key(b);return sign*(p<q?-1:p>q?1:0)};
  [...body.rows].sort(order).forEach(r=>body.append(r))};
)js";
}

}  // namespace majak::draw
