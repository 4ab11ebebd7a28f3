// SPDX-License-Identifier: Apache-2.0
#include "app/run_view.hpp"

#include <fmt/core.h>

#include <cstring>
#include <utility>
#include <variant>

#include "majak/core/error.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/view_records.hpp"
#include "majak/map/edits.hpp"
#include "majak/map/segment_map.hpp"
#include "majak/slam/reoptimise.hpp"

namespace majak::app {
namespace {

template <class... Bodies>
struct Overloaded : Bodies... {
  using Bodies::operator()...;
};
template <class... Bodies>
Overloaded(Bodies...) -> Overloaded<Bodies...>;

std::vector<std::string> commands(bool files, bool localizing) {
  if (localizing) return {"localize", "stop_localizing", "start_pose", "kidnap"};
  std::vector<std::string> may{"edit", "undo", "redo", "switch_closure", "localize"};
  if (files) may.emplace_back("write_files");
  return may;
}

EditKind kind_of(serve::EditKind kind) {
  switch (kind) {
    case serve::EditKind::erase:
      return EditKind::erase;
    case serve::EditKind::forbidden:
      return EditKind::forbidden;
    case serve::EditKind::crop:
      return EditKind::crop;
    case serve::EditKind::wall:
      return EditKind::wall;
    case serve::EditKind::turn:
    case serve::EditKind::upright:
      break;
  }
  return EditKind::turn;
}

bool same_ranges(const Scan& a, const Scan& b) {  // bit by bit: what is not a number equals nothing
  return a.ranges.size() == b.ranges.size() &&
         std::memcmp(a.ranges.data(), b.ranges.data(), a.ranges.size() * sizeof(float)) == 0;
}

/// x1 y1 x2 y2 of each. Key scans tell enough for a picture.
std::vector<float> walls_of(const Site& site) {
  Site keys;
  for (const PosedScan& posed : site.scans)
    if (posed.key) keys.scans.push_back(posed);
  std::vector<map::Segment> walls = map::build_segments(keys).segments();
  for (const map::Segment& drawn : map::drawn_walls(site, 1)) walls.push_back(drawn);
  std::vector<float> ends;
  for (const map::Segment& s : walls)
    for (const Vec2& p : {s.a, s.b})
      for (const double v : {p.x(), p.y()}) ends.push_back(static_cast<float>(v));
  return ends;
}

}  // namespace

RunView::RunView(Viewer& viewer, Site kept, std::optional<std::filesystem::path> folder,
                 Threads threads)
    : viewer_(viewer), folder_(std::move(folder)), threads_(threads), kept_(std::move(kept)) {
  if (!kept_.options_toml.empty()) options_ = options_of(kept_);
  // Somebody ended before the files had what was corrected.
  files_are_old_ = folder_ && std::filesystem::exists(io::edits_file(*folder_ / "site.majak"));
  shown_ = std::make_shared<const Site>(map::with_edits(kept_));
  grid_ = map::build_occupancy_grid(*shown_, options_.grid, threads_);
  begin();
  viewer_.set_doer([this](const serve::Command& command) { run(command); });
  tell_walls();
  wall_maker_ = std::thread([this] { make_walls(); });
}

RunView::~RunView() {
  viewer_.set_doer({});
  robot_.reset();
  {
    const std::lock_guard lock(walls_mutex_);
    ended_ = true;
  }
  walls_wanted_.notify_one();
  wall_maker_.join();
  if (!files_are_old_ || !folder_) return;
  try {
    write_files();
  } catch (const std::exception& e) {
    fmt::print(stderr, "majak: the run's files could not be written anew: {}\n", e.what());
  }
}

void RunView::begin() {
  told_ = shown_;
  changed_.assign(shown_->scans.size(), false);
  const auto view = std::make_shared<const draw::SiteView>(
      shown_, draw::SiteViewOptions{.state = robot_ ? "localizing" : "finished",
                                    .may = commands(folder_.has_value(), localizing()),
                                    .generation = viewer_.next_generation()});
  viewer_.hub().reset({view->scans(), [view](std::size_t i) { return view->scan(i); }},
                      {{"/run", view->run()},
                       {"/map", io::view_map(grid_)},
                       {"/estimates", view->estimates()},
                       {"/closures", view->closures()},
                       {"/edits", view->edits(!undone_.empty(), folder_.has_value())},
                       {"/graph", view->graph()},
                       {"/truth", view->truth()}});
}

void RunView::run(const serve::Command& command) {
  std::visit(Overloaded{[&](const serve::Edit& c) { edit(c); },
                        [&](const serve::SwitchClosure& c) { switch_closure(c); },
                        [&](const serve::Undo&) { undo(); }, [&](const serve::Redo&) { redo(); },
                        [&](const serve::WriteFiles&) { write_files(); },
                        [&](const serve::Localize& c) { localize(c); },
                        [&](const serve::StopLocalizing&) { stop_localizing(); },
                        [&](const serve::StartPose& c) { robot().start_at(c.pose); },
                        [&](const serve::Kidnap& c) { robot().kidnap(c.pose); }},
             command);
}

RobotView& RunView::robot() {
  if (!robot_) throw Error("no robot is being localized");
  return *robot_;
}

// Written down before it counts: where that fails nothing has changed.
void RunView::change(bool poses, const std::function<void(Site&)>& how) {
  if (robot_) throw Error("a robot drives in this map: stop it first");
  Site changed = kept_;
  how(changed);
  if (poses) changed = slam::reoptimised(std::move(changed), options_.mapping.graph_slam, threads_);
  if (folder_ && poses) io::write_site(*folder_ / "site.majak", changed);
  if (folder_ && !poses) io::write_edits(*folder_ / "site.majak", changed);
  const double turned = angle_diff(map::turn_of(changed), map::turn_of(kept_));
  kept_ = std::move(changed);
  files_are_old_ = true;
  shown_ = std::make_shared<const Site>(map::with_edits(kept_));
  if (folder_ && turned != 0) turn_labels(*folder_, turned);
}

void RunView::edit(const serve::Edit& wanted) {
  Edit made;
  made.kind = kind_of(wanted.kind);
  made.radians = wanted.radians;
  if (wanted.kind == serve::EditKind::upright) {
    const auto direction = map::main_direction(*shown_);
    if (!direction) throw Error("no straight wall tells which way is upright");
    made.radians = -*direction;
  } else if (made.kind != EditKind::turn) {
    made = map::anchored(*shown_, made.kind, wanted.points);
  }
  change(false, [&](Site& site) { map::add_edit(site, made); });
  undone_.clear();
  tell_changes();
}

void RunView::undo() {
  if (kept_.edits.empty()) throw Error("there is nothing to undo");
  const Edit last = kept_.edits.back();
  change(last.kind == EditKind::closure_off, [](Site& site) { map::undo_edit(site); });
  undone_.push_back(last);
  tell_changes();
}

void RunView::redo() {
  if (undone_.empty()) throw Error("there is nothing to do again");
  const Edit again = undone_.back();
  change(again.kind == EditKind::closure_off, [&](Site& site) { map::add_edit(site, again); });
  undone_.pop_back();
  tell_changes();
}

void RunView::switch_closure(const serve::SwitchClosure& wanted) {
  change(true, [&](Site& site) { map::switch_closure(site, wanted.from, wanted.to, wanted.on); });
  undone_.clear();
  tell_changes();
}

// Returns that were erased go from the page, and come back where that is undone.
void RunView::tell_changed_scans(const draw::SiteView& view) {
  std::string records;
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    if (!same_ranges(shown_->scans[i].scan, told_->scans[i].scan)) changed_[i] = true;
    if (changed_[i]) records += view.scan_number(i);
  }
  if (!records.empty())
    viewer_.hub().set("/changed_scans", std::move(records), shown_->scans.size());
}

// Most scans are as they were: what was made of them is told anew.
void RunView::tell_changes() {
  const draw::SiteView view(shown_, {});
  serve::Hub& hub = viewer_.hub();
  grid_ = map::build_occupancy_grid(*shown_, options_.grid, threads_);
  hub.set("/estimates", view.estimates());
  tell_changed_scans(view);
  hub.set("/closures", view.closures());
  hub.set("/edits", view.edits(!undone_.empty(), folder_.has_value()));
  hub.set("/map", io::view_map(grid_));
  hub.set("/graph", view.graph());
  if (std::string truth = view.truth(); !truth.empty()) hub.set("/truth", std::move(truth));
  tell_walls();
}

void RunView::tell_walls() {
  const std::lock_guard lock(walls_mutex_);
  walls_of_ = shown_;
  walls_wanted_.notify_one();
}

void RunView::make_walls() {
  std::unique_lock lock(walls_mutex_);
  while (true) {
    walls_wanted_.wait(lock, [&] { return ended_ || walls_of_; });
    if (ended_) return;
    const auto site = std::exchange(walls_of_, nullptr);
    lock.unlock();
    std::string record;
    try {
      record = io::view_segments(walls_of(*site));
    } catch (const Error&) {  // a layer less is no reason to end
    }
    lock.lock();
    if (!record.empty() && !walls_of_ && !ended_) viewer_.hub().set("/segments", std::move(record));
  }
}

void RunView::write_files() {
  if (!folder_) throw Error("this run has no folder; majak map LOG -o FOLDER --view gives it one");
  Stopwatch stopwatch;
  write_results(*folder_, kept_, options_.grid, stopwatch);
  files_are_old_ = false;
}

void RunView::localize(const serve::Localize& wanted) {
  stop_localizing();
  robot_ = std::make_unique<RobotView>(viewer_, *shown_, grid_, wanted.method);
  begin();
  tell_walls();
  robot_->start();
}

void RunView::stop_localizing() {
  if (!robot_) return;
  robot_.reset();
  begin();
  tell_walls();
}

}  // namespace majak::app
