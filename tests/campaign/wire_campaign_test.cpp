// SPDX-License-Identifier: Apache-2.0
// The campaign on the wire: controllers behind pseudo-terminals whose answers are garbled or do not
// come, whose cables are pulled out and whose power fails. GONIO_WIRE_CAMPAIGN_SESSIONS: how many.

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "sim/random.h"
#include "sim/sim_scene.h"
#include "tests/scenario/faulty_devices.h"
#include "tests/scenario/wired_bench.h"

namespace gonio {
namespace {

constexpr double kRate = 0.004;     // faults a call
constexpr double kBeside = 0.01;    // rad: an arm is not where it says
constexpr double kPosesApart = 10;  // deg

// The arms as they truly stand, whatever their controllers say.
class TrueScene final : public SimScene {
 public:
  TrueScene(const WireBench& doubles, std::shared_ptr<const SimLamp> lamp)
      : doubles_(doubles), lamp_(std::move(lamp)) {}
  Result<void> Look() override { return {}; }
  SimArms ArmsAt(Seconds) const override {
    SimArms arms{};
    for (std::size_t i = 0; i < arms.size(); ++i) arms[i] = doubles_.Angle(i);
    return arms;
  }
  bool MovingBetween(Seconds, Seconds) const override { return false; }
  double PowerAt(Seconds time) const override { return lamp_->PowerAt(time); }
  Rgb SpectrumAt(Seconds time) const override { return lamp_->SpectrumAt(time); }

 private:
  const WireBench& doubles_;
  const std::shared_ptr<const SimLamp> lamp_;
};

struct Tally {
  std::map<std::string, int> outcomes, faults;
  int poses = 0;
  int reopened = 0;
};

// What happens on the wires, drawn from a seed.
class WireTrouble {
 public:
  WireTrouble(std::uint64_t seed, Tally* tally) : random_(seed, 3), tally_(*tally) {
    bench_.rig.failures.axis = {.retries = 6, .wait = Seconds(1), .then = FailureAction::kStop};
    bench_.rig.failures.max_in_a_row = 20;
  }

  void Run(std::uint64_t seed) {
    Watch();
    ScriptedPlanner planner(Poses());
    SessionParts parts{.rig = bench_.rig,
                       .devices = bench_.devices,
                       .clock = bench_.wire_clock(),
                       .planner = planner,
                       .log = nullptr};
    parts.reopen = [&](FailureClass) { return Reopen(); };
    const SessionSummary summary = RunSession(parts, {});
    ++tally_.outcomes[ToString(summary.outcome)];
    tally_.poses += static_cast<int>(summary.poses.size());
    for (const SessionPose& pose : summary.poses) {
      EXPECT_TRUE(pose.samples.front().f_r.isApprox(Rgb(0.2, 0.4, 0.6) / kPi, 0.01))
          << "seed " << seed << ": " << pose.samples.front().f_r;
    }
    EXPECT_EQ(bench_.lamp->level(), 0) << "seed " << seed;
    bench_.devices.camera.reset();
    if (HasFailure()) fmt::print("seed {}: {}\n", seed, summary.reason);
  }

 private:
  static bool HasFailure() { return testing::Test::HasFailure(); }

  static std::vector<HalfDiff> Poses() {
    std::vector<HalfDiff> poses;
    for (int i = 0; i < 8; ++i) poses.push_back(Degrees(5 + kPosesApart * (i % 4), 15 + 5 * i));
    return poses;
  }

  // At calls through the interface, so that it is known when; the trouble is on the wire.
  void Watch() {
    const FaultScript script = [this](const std::string& device, const std::string&) {
      if (device == "camera") CheckArms();
      MakeTrouble();
      return std::nullopt;
    };
    for (auto& axis : bench_.devices.axes) {
      axis = std::make_unique<FaultyAxis>(std::move(axis), script);
    }
    bench_.devices.camera = std::make_unique<FaultyCamera>(
        std::make_unique<SimCamera>("camera", bench_.rig.camera, WiredBench::Perfect(),
                                    bench_.sample,
                                    std::make_unique<TrueScene>(bench_.doubles(), bench_.lamp),
                                    bench_.wire_clock(), Random(1, 20)),
        script);
  }

  void MakeTrouble() {
    if (random_.Uniform() >= kRate) return;
    const char* const port = PortOf(random_.Uniform());
    const auto axis = static_cast<std::size_t>(kAxes * random_.Uniform());
    const double kind = random_.Uniform();
    if (kind < 0.4) {
      ++tally_.faults["answers garbled"];
      bench_.line(port).Garble(1 + static_cast<int>(3 * random_.Uniform()));
    } else if (kind < 0.55) {
      ++tally_.faults["cable pulled out"];
      bench_.line(port).HangUp();
      pulled_ = port;
    } else if (kind < 0.7) {
      ++tally_.faults["power failed and came back"];
      bench_.doubles().Reset(axis);
    } else if (kind < 0.85) {
      ++tally_.faults["motor without power"];
      bench_.doubles().CutMotorPower(axis);
    } else {
      ++tally_.faults["no answer"];
      bench_.line(port).set_silent(true);
      silent_ = port;
    }
  }

  static const char* PortOf(double u) { return u < 0.5 ? "chain" : u < 0.75 ? "first" : "second"; }

  // While a frame is taken every arm is where its controller says, or the controller says that it
  // does not know.
  void CheckArms() {
    for (int i = 0; i < kAxes; ++i) {
      const auto state = bench_.devices.axes[i]->State();
      if (!state || !state->homed) continue;
      EXPECT_NEAR(bench_.doubles().Angle(i), state->position, kBeside) << kAxisNames[i];
    }
  }

  Result<void> Reopen() {
    ++tally_.reopened;
    bench_.devices.camera.reset();
    for (auto& axis : bench_.devices.axes) axis.reset();
    if (!silent_.empty()) bench_.line(silent_).set_silent(false);
    silent_.clear();
    if (!pulled_.empty()) bench_.doubles().Replug(pulled_);
    pulled_.clear();
    auto opened = bench_.OpenAxes();
    if (!opened) return opened;
    Watch();
    return {};
  }

  Random random_;
  Tally& tally_;
  WiredBench bench_;
  std::string silent_, pulled_;
};

TEST(WireCampaign, NoArmIsTakenForOneThatStandsElsewhere) {
  const char* const wanted = std::getenv("GONIO_WIRE_CAMPAIGN_SESSIONS");
  const int sessions = wanted != nullptr ? std::atoi(wanted) : 4;
  Tally tally;
  for (int seed = 1; seed <= sessions; ++seed) WireTrouble(seed, &tally).Run(seed);
  for (const auto& [outcome, count] : tally.outcomes) fmt::print("{:28} {}\n", outcome, count);
  for (const auto& [fault, count] : tally.faults) fmt::print("{:28} {}\n", fault, count);
  fmt::print("{} poses, opened anew {} times\n", tally.poses, tally.reopened);
  EXPECT_GT(tally.poses, 0);
  EXPECT_FALSE(tally.faults.empty());
}

}  // namespace
}  // namespace gonio
