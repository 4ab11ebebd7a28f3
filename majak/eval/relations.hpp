// SPDX-License-Identifier: Apache-2.0
// Relations: relative poses between two scan times that a person has checked, and how far a
// trajectory is from them (Kümmerle et al. 2009, "On measuring the accuracy of SLAM algorithms",
// eq. 4 and 5: the mean of the absolute translational and rotational differences).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "majak/eval/statistics.hpp"
#include "majak/eval/trajectory.hpp"

namespace majak::eval {

/// The pose at time `to` in the frame of the pose at time `from`.
struct Relation {
  Time from = 0;
  Time to = 0;
  Pose2 T_from_to;
  std::int64_t line = 0;  ///< in its file

  Duration span() const { return to > from ? to - from : from - to; }
};

/// Lines `t1 t2 x y z roll pitch yaw` (s, m, rad); z, roll and pitch are dropped. Damaged lines are
/// skipped and counted; throws Error if no line holds a relation.
std::vector<Relation> read_relations(std::unique_ptr<io::ByteStream> bytes, const std::string& name,
                                     Report& report);
std::vector<Relation> read_relations(const std::string& path, Report& report);

struct RelationOptions {
  LookupOptions lookup;
  Duration short_span = 20 * kSecond;  ///< ns; stamps further apart make a loop relation
};

/// How far the trajectory is from one relation.
struct RelationResidual {
  std::size_t relation = 0;  ///< index into the relations
  double translation = 0;    ///< m
  double rotation = 0;       ///< rad, >= 0
  Pose2 T_truth_estimate;    ///< the difference itself, in the frame of the relation's second pose
  bool exact = false;        ///< both stamps are in the trajectory; else one was interpolated
};

struct RelationErrors {
  ErrorStats translation;  ///< m
  ErrorStats rotation;     ///< rad
};

struct RelationResult {
  RelationErrors all;
  RelationErrors near;  ///< stamps at most short_span apart
  RelationErrors loop;  ///< further apart
  std::vector<RelationResidual> residuals;
  std::size_t exact = 0;
  std::size_t interpolated = 0;
  std::size_t unmatched = 0;  ///< a stamp outside the trajectory or in a gap of it
};

/// Compares poses as they stand. Frames: the relation and the trajectory must be of the same body.
RelationResult evaluate_relations(const Trajectory& trajectory,
                                  const std::vector<Relation>& relations,
                                  const RelationOptions& options = {});

enum class BodyFrame { robot, laser };

/// Files of relations do not say whether they relate robot or laser poses, so both are tried.
struct RelationEvaluation {
  RelationResult robot;
  std::optional<RelationResult> laser;  ///< none when the laser sits at the robot's centre
  BodyFrame better = BodyFrame::robot;  ///< lower mean translational error over all relations

  const RelationResult& best() const { return better == BodyFrame::laser ? *laser : robot; }
};

/// `robot` holds poses of the robot; T_robot_laser is the mounting.
RelationEvaluation evaluate_relations_in_both_frames(const Trajectory& robot,
                                                     const Pose2& T_robot_laser,
                                                     const std::vector<Relation>& relations,
                                                     const RelationOptions& options = {});

}  // namespace majak::eval
