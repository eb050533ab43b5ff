// SPDX-License-Identifier: Apache-2.0
#include "acquisition/path_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

constexpr double kWideStep = kPi / 4;    // of the search, rad
constexpr double kNarrowStep = kPi / 8;  // rad
constexpr int kMostNodes = 4000;         // the search gives up

// Which axes have arrived: bit i of axis i.
using Arrived = unsigned;
constexpr Arrived kAllArrived = (1u << kAxes) - 1;

AxisPositions Mixed(const AxisPositions& from, const AxisPositions& to, Arrived arrived) {
  AxisPositions angles = from;
  for (int i = 0; i < kAxes; ++i) {
    if ((arrived >> i & 1) != 0) angles[i] = to[i];
  }
  return angles;
}

// The values of each axis between which the search goes one step at a time.
using Lattice = std::array<std::vector<double>, kAxes>;
using Node = std::array<int, kAxes>;  // indices

// Axes that go a half turn at most are searched in smaller steps.
double SearchStep(RigKind kind, int axis) {
  const Range degrees = AllowedDegrees(kind, axis);
  return degrees.max - degrees.min > 180 ? kWideStep : kNarrowStep;
}

Lattice MakeLattice(RigKind kind, const AxisPositions& from, const AxisPositions& to,
                    const std::array<AxisLimits, kAxes>& limits) {
  Lattice lattice;
  for (int i = 0; i < kAxes; ++i) {
    const double step = SearchStep(kind, i);
    const double low = limits[i].min_position;
    const double high = limits[i].max_position;
    std::vector<double>& values = lattice[i];
    values = {from[i], to[i], low, high};
    for (double k = std::ceil(low / step); k * step < high; ++k) values.push_back(k * step);
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
  }
  return lattice;
}

Node NodeAt(const Lattice& lattice, const AxisPositions& angles) {
  Node node{};
  for (int i = 0; i < kAxes; ++i) {
    node[i] = static_cast<int>(std::find(lattice[i].begin(), lattice[i].end(), angles[i]) -
                               lattice[i].begin());
  }
  return node;
}

AxisPositions AnglesAt(const Lattice& lattice, const Node& node) {
  AxisPositions angles{};
  for (int i = 0; i < kAxes; ++i) angles[i] = lattice[i][node[i]];
  return angles;
}

// Hands every neighbour of a node to visit(neighbour).
template <typename Visit>
void VisitNeighbours(const Lattice& lattice, const Node& node, const Visit& visit) {
  for (int i = 0; i < kAxes; ++i) {
    for (const int step : {-1, 1}) {
      Node next = node;
      next[i] += step;
      if (next[i] >= 0 && next[i] < std::ssize(lattice[i])) visit(next);
    }
  }
}

}  // namespace

PathPlanner::PathPlanner(const RigConfig& rig)
    : keep_out_(rig), kinematics_(rig), kind_(rig.geometry.kind), axes_(rig.axes) {
  std::transform(axes_.begin(), axes_.end(), targets_.begin(), TargetLimits);
}

// An axis that turns passes its target on the way.
std::optional<Contact> PathPlanner::FindOnLeg(const AxisPositions& from,
                                              const AxisPositions& to) const {
  AxisPositions low{};
  AxisPositions high{};
  for (int i = 0; i < kAxes; ++i) {
    const double turn = TurningPoint(from[i], to[i], axes_[i]).value_or(to[i]);
    low[i] = std::min({from[i], to[i], turn});
    high[i] = std::max({from[i], to[i], turn});
  }
  return keep_out_.FindBetween(kinematics_.TruePositions(low), kinematics_.TruePositions(high));
}

// Dijkstra over which axes have arrived: at most 65 legs.
std::optional<Path> PathPlanner::PlanInOrder(const AxisPositions& from,
                                             const AxisPositions& to) const {
  Arrived start = 0;
  for (int i = 0; i < kAxes; ++i) {
    if (from[i] == to[i]) start |= 1u << i;
  }
  std::array<double, kAllArrived + 1> cost;
  cost.fill(std::numeric_limits<double>::infinity());
  std::array<Arrived, kAllArrived + 1> before{};
  cost[start] = 0;
  // Arriving only adds bits, so that in ascending order every predecessor is done.
  for (Arrived a = start; a < kAllArrived; ++a) {
    if (std::isinf(cost[a])) continue;
    for (Arrived b = a + 1; b <= kAllArrived; ++b) {
      if ((a & b) != a) continue;
      const AxisPositions leg_from = Mixed(from, to, a);
      const AxisPositions leg_to = Mixed(from, to, b);
      const double arrival = cost[a] + kinematics_.TravelTime(leg_from, leg_to).count();
      if (arrival >= cost[b] || FindOnLeg(leg_from, leg_to)) continue;
      cost[b] = arrival;
      before[b] = a;
    }
  }
  if (std::isinf(cost[kAllArrived])) return std::nullopt;
  Path path;
  for (Arrived a = kAllArrived; a != start; a = before[a]) path.push_back(Mixed(from, to, a));
  std::reverse(path.begin(), path.end());
  return path;
}

// A* (Hart, Nilsson and Raphael, 1968): what is left takes at least the time of all axes together.
std::optional<Path> PathPlanner::PlanAround(const AxisPositions& from,
                                            const AxisPositions& to) const {
  const Lattice lattice = MakeLattice(kind_, from, to, targets_);
  const Node start = NodeAt(lattice, from);
  const Node goal = NodeAt(lattice, to);
  struct Reached {
    double cost = 0;
    Node before{};
    bool done = false;
  };
  std::map<Node, Reached> reached = {{start, {}}};
  using Entry = std::pair<double, Node>;  // cost by way of it, at least
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  open.emplace(0, start);
  for (int nodes = 0; !open.empty() && nodes < kMostNodes; ++nodes) {
    const Node node = open.top().second;
    open.pop();
    Reached& here = reached.at(node);
    if (std::exchange(here.done, true)) continue;
    if (node == goal) break;
    const AxisPositions angles = AnglesAt(lattice, node);
    VisitNeighbours(lattice, node, [&](const Node& next) {
      const AxisPositions there = AnglesAt(lattice, next);
      const double cost = here.cost + kinematics_.TravelTime(angles, there).count();
      const auto known = reached.find(next);
      if (known != reached.end() && (known->second.done || known->second.cost <= cost)) return;
      if (FindOnLeg(angles, there)) return;
      reached[next] = {.cost = cost, .before = node};
      open.emplace(cost + kinematics_.TravelTime(there, to).count(), next);
    });
  }
  if (!reached.contains(goal) || !reached.at(goal).done) return std::nullopt;
  Path path;
  for (Node node = goal; node != start; node = reached.at(node).before) {
    path.push_back(AnglesAt(lattice, node));
  }
  std::reverse(path.begin(), path.end());
  return path;
}

Path PathPlanner::Shortened(const AxisPositions& from, Path path) const {
  Path shorter;
  AxisPositions here = from;
  for (std::size_t i = 0; i < path.size();) {
    std::size_t next = path.size() - 1;
    while (next > i && FindOnLeg(here, path[next])) --next;
    shorter.push_back(path[next]);
    here = path[next];
    i = next + 1;
  }
  return shorter;
}

Result<Path> PathPlanner::Plan(const AxisPositions& from, const AxisPositions& to) const {
  if (keep_out_.empty()) return Path{to};
  if (const auto contact = keep_out_.FindAt(kinematics_.TruePositions(from))) {
    return Error{ErrorCode::kProtocol,
                 "the axes are where they must not be, move them by hand: " + contact->Text()};
  }
  if (const auto contact = keep_out_.FindAt(kinematics_.TruePositions(to))) {
    return Error{ErrorCode::kRefused, contact->Text()};
  }
  const auto in_the_way = FindOnLeg(from, to);
  if (!in_the_way) return Path{to};
  if (auto path = PlanInOrder(from, to)) return *path;
  if (auto path = PlanAround(from, to)) return Shortened(from, *path);
  return Error{ErrorCode::kRefused, "there is no way around: " + in_the_way->Text()};
}

Result<Path> PathPlanner::PlanTo(const AxisPositions& from, const DirectionPair& pair) const {
  const HalfDiff angles = ToHalfDiff(pair);
  std::string why = "out of reach";
  for (const AxisPositions& to : kinematics_.Solutions(pair, from)) {
    Result<Path> path = Plan(from, to);
    if (path.ok() || path.error().code != ErrorCode::kRefused) return path;
    why = path.error().message;
  }
  return Error{ErrorCode::kRefused,
               fmt::format("pose theta_h {:.2f}, theta_d {:.2f}, phi_d {:.2f} deg: {}",
                           DegFromRad(angles.theta_h), DegFromRad(angles.theta_d),
                           DegFromRad(angles.phi_d), why)};
}

std::vector<bool> PathPlanner::Connected(std::span<const DirectionPair> poses) const {
  struct Group {
    AxisPositions somewhere{};
    std::vector<std::size_t> poses;
  };
  std::vector<Group> groups;
  std::size_t last = 0;  // the group of the pose before: neighbours are quickly connected
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto join = [&](std::size_t g) {
      const auto path = PlanTo(groups[g].somewhere, poses[i]);
      if (!path.ok()) return false;
      groups[g].somewhere = path->back();
      groups[g].poses.push_back(i);
      last = g;
      return true;
    };
    if (!groups.empty() && join(last)) continue;
    bool joined = false;
    for (std::size_t g = 0; g < groups.size() && !joined; ++g) joined = g != last && join(g);
    if (joined) continue;
    for (const AxisPositions& to : kinematics_.Solutions(poses[i], AxisPositions{})) {
      if (keep_out_.FindAt(kinematics_.TruePositions(to))) continue;
      last = groups.size();
      groups.push_back({to, {i}});
      break;
    }
  }
  std::vector<bool> connected(poses.size(), false);
  const auto largest = std::max_element(
      groups.begin(), groups.end(),
      [](const Group& a, const Group& b) { return a.poses.size() < b.poses.size(); });
  if (largest == groups.end()) return connected;
  for (const std::size_t i : largest->poses) connected[i] = true;
  return connected;
}

Seconds PathPlanner::TravelTime(const AxisPositions& from, const Path& path) const {
  Seconds time{0};
  AxisPositions here = from;
  for (const AxisPositions& leg : path) {
    time += kinematics_.TravelTime(here, leg);
    here = leg;
  }
  return time;
}

}  // namespace gonio
