// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/relations.hpp"

#include <cmath>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/eval/comment.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"

namespace majak::eval {
namespace {

RelationErrors errors_of(const std::vector<RelationResidual>& residuals,
                         const std::vector<Relation>& relations, Duration above, Duration up_to) {
  std::vector<double> translation, rotation;
  for (const RelationResidual& r : residuals) {
    const Duration span = relations[r.relation].span();
    if (span <= above || span > up_to) continue;
    translation.push_back(r.translation);
    rotation.push_back(r.rotation);
  }
  return {error_stats(std::move(translation)), error_stats(std::move(rotation))};
}

constexpr const char* kNotPlanar = "relations: z, roll or pitch of a relation dropped";

/// Fills the relation; says what is wrong with the line, or nullptr.
const char* parse_relation(io::Fields fields, Relation& relation) {
  double x = 0, y = 0, z = 0, roll = 0, pitch = 0, yaw = 0;
  if (!fields.time(relation.from) || !fields.time(relation.to) || !fields.number(x) ||
      !fields.number(y) || !fields.number(z) || !fields.number(roll) || !fields.number(pitch) ||
      !fields.number(yaw) || !fields.at_end() || !std::isfinite(x + y + z + roll + pitch + yaw)) {
    return "relations: line is not `t1 t2 x y z roll pitch yaw`";
  }
  relation.T_from_to = {x, y, wrap_angle(yaw)};
  return z != 0 || roll != 0 || pitch != 0 ? kNotPlanar : nullptr;
}

}  // namespace

std::vector<Relation> read_relations(std::unique_ptr<io::ByteStream> bytes, const std::string& name,
                                     Report& report) {
  io::LineReader lines(std::move(bytes));
  std::vector<Relation> relations;
  while (const auto line = lines.next()) {
    if (is_comment(*line)) continue;
    Relation relation;
    relation.line = lines.line();
    if (const char* const fault = parse_relation(io::Fields(*line), relation)) {
      report.count(fault, lines.line());
      if (fault == kNotPlanar) relations.push_back(relation);
    } else {
      relations.push_back(relation);
    }
  }
  const Report noticed = lines.report();
  for (const auto& [what, entry] : noticed.entries()) report.add(what, entry);
  if (relations.empty()) {
    throw Error(name + ": no relation in it; expected lines `t1 t2 x y z roll pitch yaw`");
  }
  return relations;
}

std::vector<Relation> read_relations(const std::string& path, Report& report) {
  return read_relations(io::open_bytes(path).bytes, path, report);
}

RelationResult evaluate_relations(const Trajectory& trajectory,
                                  const std::vector<Relation>& relations,
                                  const RelationOptions& options) {
  const TrajectoryIndex index(trajectory, options.lookup);
  RelationResult result;
  for (std::size_t i = 0; i < relations.size(); ++i) {
    const auto from = index.at(relations[i].from);
    const auto to = index.at(relations[i].to);
    if (!from || !to) {
      ++result.unmatched;
      continue;
    }
    const Pose2 error = between(relations[i].T_from_to, between(from->pose, to->pose));
    const bool exact = from->exact && to->exact;
    ++(exact ? result.exact : result.interpolated);
    result.residuals.push_back(
        {i, std::hypot(error.x, error.y), std::abs(error.theta), error, exact});
  }
  constexpr Duration kForever = std::numeric_limits<Duration>::max();
  result.all = errors_of(result.residuals, relations, -1, kForever);
  result.near = errors_of(result.residuals, relations, -1, options.short_span);
  result.loop = errors_of(result.residuals, relations, options.short_span, kForever);
  return result;
}

RelationEvaluation evaluate_relations_in_both_frames(const Trajectory& robot,
                                                     const Pose2& T_robot_laser,
                                                     const std::vector<Relation>& relations,
                                                     const RelationOptions& options) {
  RelationEvaluation both;
  both.robot = evaluate_relations(robot, relations, options);
  if (T_robot_laser == Pose2{}) return both;
  Trajectory laser = robot;
  for (StampedPose& p : laser) p.pose = p.pose * T_robot_laser;
  both.laser = evaluate_relations(laser, relations, options);
  if (both.laser->all.translation.mean < both.robot.all.translation.mean)
    both.better = BodyFrame::laser;
  return both;
}

}  // namespace majak::eval
