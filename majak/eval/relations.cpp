// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/relations.hpp"

#include <cmath>
#include <fstream>
#include <istream>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/eval/fields.hpp"

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

}  // namespace

std::vector<Relation> read_relations(std::istream& in, const std::string& name, Report& report) {
  std::vector<Relation> relations;
  std::string line;
  for (std::int64_t number = 1; std::getline(in, line); ++number) {
    const auto fields = split_fields(line);
    if (fields.empty()) continue;
    const auto from = parse_stamp(fields[0]);
    const auto to = fields.size() == 8 ? parse_stamp(fields[1]) : std::nullopt;
    const auto values = parse_numbers<6>(fields, 2);
    if (!from || !to || !values) {
      report.count("relations: line is not `t1 t2 x y z roll pitch yaw`", number);
      continue;
    }
    const auto& [x, y, z, roll, pitch, yaw] = *values;
    if (z != 0 || roll != 0 || pitch != 0) {
      report.count("relations: z, roll or pitch of a relation dropped", number);
    }
    relations.push_back({*from, *to, {x, y, wrap_angle(yaw)}, number});
  }
  if (relations.empty()) {
    throw Error(name + ": no relation in it; expected lines `t1 t2 x y z roll pitch yaw`");
  }
  return relations;
}

std::vector<Relation> read_relations(const std::string& path, Report& report) {
  std::ifstream in(path);
  if (!in) throw Error(path + ": cannot be read; check the name and the reading rights");
  return read_relations(in, path, report);
}

RelationResult evaluate_relations(const Trajectory& trajectory, const std::vector<Relation>& relations,
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

RelationEvaluation evaluate_relations_in_both_frames(const Trajectory& robot, const Pose2& T_robot_laser,
                                                     const std::vector<Relation>& relations,
                                                     const RelationOptions& options) {
  RelationEvaluation both;
  both.robot = evaluate_relations(robot, relations, options);
  if (T_robot_laser == Pose2{}) return both;
  Trajectory laser = robot;
  for (StampedPose& p : laser) p.pose = p.pose * T_robot_laser;
  both.laser = evaluate_relations(laser, relations, options);
  if (both.laser->all.translation.mean < both.robot.all.translation.mean) both.better = BodyFrame::laser;
  return both;
}

}  // namespace majak::eval
