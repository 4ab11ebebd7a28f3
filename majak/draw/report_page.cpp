// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/report_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace majak::draw {
namespace {

constexpr std::size_t kSkippedRows = 100;

/// The colour that the style sheet gives a layer, where it is not called like it.
std::string swatch_of(const std::string& style) {
  if (style == "ellipses") return "ellipse";
  if (style == "rejected") return "odometry";
  if (style == "fixes") return "strained";
  if (style == "seen" || style == "trunks") return "poor";
  if (style == "known") return "good";
  return style;
}

std::string keys(const std::vector<Layer>& layers) {
  std::string out = "<div class=\"keys\">\n";
  for (const Layer& layer : layers) {
    const std::string colour = layer.style.substr(layer.style.find('.') + 1);
    const std::string swatch =
        layer.style == "picture"
            ? ""
            : fmt::format("<i class=\"swatch\" style=\"--c:var(--{})\"></i>", swatch_of(colour));
    out += fmt::format("<label><input type=\"checkbox\" data-layer=\"{}\"{}>{}{}</label>\n",
                       layer.style, layer.shown ? " checked" : "", swatch, escape(layer.label));
  }
  return out +
         "<span><button id=\"in\" type=\"button\">+</button> <button id=\"out\" "
         "type=\"button\">&minus;</button> "
         "<button id=\"home\" type=\"button\">whole map</button></span></div>\n";
}

/// Layers that start switched off get their class in the text, so that the page needs no script to
/// be right.
std::string with_hidden_layers(std::string svg, const std::vector<Layer>& layers) {
  for (const Layer& layer : layers) {
    if (layer.shown) continue;
    std::string classes = layer.style;
    std::replace(classes.begin(), classes.end(), '.', ' ');
    for (const char* kind : {"layer line ", "layer "}) {
      const std::string attribute = fmt::format("class=\"{}{}\"", kind, classes);
      const std::size_t place = svg.find(attribute);
      if (place == std::string::npos) continue;
      svg.insert(place + attribute.size() - 1, " hide");
      break;
    }
  }
  return svg;
}

}  // namespace

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
section:not(.majak section){background:var(--card);border:1px solid var(--rule);border-radius:10px;padding:18px 20px;
margin:16px 0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;margin:16px 0}
.tile{background:var(--card);border:1px solid var(--rule);border-radius:10px;padding:12px 14px}
.tile b{display:block;font-size:21px;font-weight:650;letter-spacing:-.01em;white-space:nowrap}
.tile span{color:var(--soft);font-size:13px}.tile i{display:block;font-style:normal}
.wide{width:min(96vw,1600px);margin:16px calc(50% - min(48vw,800px))}
.wide>div{height:82vh;border:1px solid var(--rule);border-radius:10px;overflow:hidden}
svg:not(.majak svg){display:block;width:100%;height:auto}
svg text{fill:var(--soft);font-size:12px;font-family:inherit}
.map{max-height:82vh;border-radius:6px;background:#cdcdcd;touch-action:none;cursor:grab}
.map .picture{image-rendering:pixelated}@media(prefers-color-scheme:dark){.map{background:#2e2e2e}}
.line{fill:none;stroke-width:1.6;stroke-linecap:round;stroke-linejoin:round;
vector-effect:non-scaling-stroke}.line.after{stroke:var(--after)}.line.before{stroke:var(--before)}
.line.odometry{stroke:var(--odometry)}.line.truth{stroke:var(--truth)}
.line.weak{stroke:var(--weak);stroke-width:4;stroke-opacity:.75}
.line.lost{stroke:var(--lost);stroke-width:5}
.map.plain{background:var(--page)}.line.fixes{stroke:var(--strained);stroke-width:4}
.line.seen{stroke:var(--poor);stroke-width:2;stroke-opacity:.5}
.line.known{stroke:var(--good);stroke-width:2;stroke-opacity:.5}
.line.trunks{stroke:var(--poor);stroke-width:5}
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

std::string page(const std::string& title, const std::string& lead, const std::string& body,
                 const std::string& footer) {
  const bool has_map = body.find("id=\"map\"") != std::string::npos;
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0} - "
      "majak</title>\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><meta "
      "name=\"color-scheme\" content=\"light dark\">\n"
      "<style>{1}</style></head>\n<body><main>\n<h1>{0}</h1>\n<p class=\"lead soft\">{2}</p>\n{3}"
      "<footer>{4}</footer>\n</main>\n<script>{5}</script>\n</body></html>\n",
      escape(title), report_style(), escape(lead), body, escape(footer),
      has_map ? report_script() : "");
}

std::string section(const std::string& title, const std::string& body) {
  return body.empty() ? "" : fmt::format("<section>\n<h2>{}</h2>\n{}</section>\n", title, body);
}

std::string list(const std::vector<std::string>& sentences) {
  std::string out = "<ul>\n";
  for (const std::string& sentence : sentences) out += "<li>" + escape(sentence) + "</li>\n";
  return out + "</ul>\n";
}

std::string tile(const std::string& value, const std::string& label, const std::string& more) {
  return fmt::format("<div class=\"tile\"><b>{}</b><span>{}<i>{}</i></span></div>\n", value, label,
                     more);
}

std::string table(const std::vector<std::string>& head,
                  const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return "";
  const auto row = [](const std::vector<std::string>& cells, const char* tag) {
    std::string out = "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i)
      out += fmt::format("<{0}{1}>{2}</{0}>", tag, i == 0 ? " class=\"l\"" : "", escape(cells[i]));
    return out + "</tr>\n";
  };
  std::string out = "<table>";
  if (!head.empty()) out += "<thead>" + row(head, "th") + "</thead>";
  out += "<tbody>\n";
  for (const auto& cells : rows) out += row(cells, "td");
  return out + "</tbody></table>\n";
}

std::string figure_in_page(const Figure& figure, const std::string& what) {
  return fmt::format(
      "<p><img alt=\"{}\" style=\"width:100%\" src=\"data:image/svg+xml;base64,{}\"></p>\n",
      escape(what), base64(figure_svg(figure)));
}

std::string skipped_section(const Report& report) {
  if (report.empty())
    return section("Skipped",
                   "<p class=\"soft\">Nothing: every record was understood and used.</p>\n");
  std::vector<std::vector<std::string>> rows;
  for (const auto& [what, entry] : report.entries()) {
    if (rows.size() == kSkippedRows) break;
    rows.push_back({what, std::to_string(entry.count),
                    entry.first_line > 0 ? std::to_string(entry.first_line) : ""});
  }
  return section("Skipped and noticed", table({"what", "how many", "first at line"}, rows));
}

std::string clock(double seconds) {
  const auto whole = static_cast<long long>(std::llround(seconds));
  if (whole >= 3600)
    return fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02} min", whole / 60, whole % 60);
}

std::string metres(double value) {
  return value < 0.995 ? number(100 * value, value < 0.1 ? 1 : 0) + " cm"
                       : number(value, value < 100 ? 1 : 0) + " m";
}

std::string switched_map(std::string svg, const std::vector<Layer>& layers) {
  return with_hidden_layers(std::move(svg), layers) + keys(layers);
}

}  // namespace majak::draw
