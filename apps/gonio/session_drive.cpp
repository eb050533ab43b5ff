// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/session_drive.h"

#include <fmt/format.h>
#include <unistd.h>

#include <optional>
#include <stdexcept>

#include "acquisition/time_estimate.h"
#include "apps/gonio/device_error.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/notify.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/status_file.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "fitting/fit.h"
#include "fitting/process_fit.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWireLog = "wire.log";

void PrintSession(const SessionSummary& s) {
  fmt::print("session          {}: {}\n", ToString(s.outcome), s.reason);
  fmt::print("poses            {} measured with {} frames, {} refused\n", s.poses.size(), s.frames,
             s.rejected);
  fmt::print("time on the rig  {} (homing {}, moving {}, exposing {})\n", ForPeople(s.duration),
             ForPeople(s.preparation), ForPeople(s.travel), ForPeople(s.exposing));
  if (s.reference_visits > 0) {
    fmt::print(
        "reference        {} visits; the gain is now {:.4f} +- {:.4f}, {:.4f} +- {:.4f}, "
        "{:.4f} +- {:.4f} of the first\n",
        s.reference_visits, s.gain.value[0], s.gain.sigma[0], s.gain.value[1], s.gain.sigma[1],
        s.gain.value[2], s.gain.sigma[2]);
  }
  for (const std::string& warning : s.warnings) fmt::print(stderr, "gonio: warning: {}\n", warning);
  if (s.predicted_error) fmt::print("predicted error  {:.5f}\n", *s.predicted_error);
}

// What the same instrument would need for a dense scan that exposes as long per pose as this
// session.
void PrintDense(const SessionSummary& s, const RigConfig& rig) {
  const TimeEstimate dense =
      EstimateDenseScan(rig, s.exposing / static_cast<double>(s.poses.size()));
  fmt::print("dense scan       {} for {} poses: {:.1f} times as long\n", ForPeople(dense.total()),
             dense.poses, dense.total() / s.duration);
}

// What went wrong is for standard error; what was measured is safe either way.
void ReportFault(const SessionSummary& summary, const fs::path& out) {
  if (!IsFault(summary.outcome)) return;
  fmt::print(stderr, "gonio: {} ({} poses are safe in {})\n", summary.reason, summary.poses.size(),
             out.string());
}

// How much went over each wire, all of which is in DIR/wire.log.
void RecordWires(const LinkLog& wires, const SessionSummary& summary, EventLog& log) {
  for (const auto& [link, count] : wires.Counts()) {
    (void)log.AppendNote(
        summary.duration, "wire",
        fmt::format("{}: {} messages sent, {} bytes, {} received; {} calls failed", link,
                    count.sent, count.bytes_sent, count.bytes_received, count.failures));
  }
}

// "612 frames, 14 taken again (13 missing packets, 1 none), 3 of earlier settings, ...".
std::string TextOf(const GenicamCounters& counters) {
  std::string bad;
  for (const auto& [what, count] : counters.bad) {
    bad += fmt::format("{}{} {}", bad.empty() ? " (" : ", ", count, what);
  }
  if (!bad.empty()) bad += ")";
  return fmt::format(
      "{} frames, {} taken again{}, {} that were taken with earlier settings, {} discarded after a "
      "change, lost and found {} times",
      counters.frames, counters.retries, bad, counters.late, counters.discarded, counters.reopened);
}

void FitAndPrint(const SessionSummary& summary, const SessionSetup& setup, const fs::path& out) {
  try {
    const DsbrdfFit fit = FitDsbrdf(summary.Samples(), setup.plan.prior, setup.plan.fit);
    WriteFit(out / kFitFile, fit);
    PrintFit(fit, setup.plan.prior);
    if (setup.material) PrintMale(*setup.material, fit, "the material's file");
    if (setup.material && setup.plan.prior.process) {
      fmt::print("with what DSBRDF cannot say (the process of prior {}):\n", setup.plan.prior.name);
      PrintMale(*setup.material, *FitProcess(summary.Samples(), setup.plan.prior),
                "the material's file");
    }
  } catch (const ConfigError& e) {
    // Not the user's configuration: the measurement gave nothing to fit.
    throw std::runtime_error(
        fmt::format("{}: measured, but cannot be fitted: {}", out.string(), e.what()));
  }
  PrintDense(summary, setup.rig.config);
}

// Devices that failed, opened anew; between interlocks and devices there is nobody then.
Result<void> ReopenFor(const DriveParts& parts, Interlocks* interlocks, FailureClass failure) {
  if (interlocks != nullptr) interlocks->Release(parts.rig.devices);
  const auto opened =
      Reopen(parts.setup.rig, parts.setup.SimulatedSample(), parts.seed, failure, parts.rig);
  if (interlocks != nullptr) interlocks->Wrap(parts.rig.devices);
  return opened;
}

SessionSummary Measure(const DriveParts& parts, const DriveOptions& options, const fs::path& dir) {
  const SessionSetup& setup = parts.setup;
  OpenedRig& rig = parts.rig;
  std::optional<Interlocks> interlocks;
  if (!setup.rig.interlocks.signals.empty()) {
    interlocks.emplace(setup.rig.interlocks, rig.devices, *rig.clock, dir);
    interlocks->WatchWith(*rig.clock);
  }
  Interlocks* const watch = interlocks ? &*interlocks : nullptr;
  const bool terminal = ::isatty(STDIN_FILENO) != 0 && ::isatty(STDERR_FILENO) != 0;
  Interrupt interrupt(terminal ? STDIN_FILENO : -1);
  ProgressLine line("measuring", options.quiet);
  StatusFile status(dir);
  Notifier notifier(options.notify, dir);
  const SessionParts session{
      .rig = setup.rig.config,
      .devices = rig.devices,
      .clock = *rig.clock,
      .planner = parts.planner,
      .log = &parts.log,
      .calibrations = &parts.calibrations,
      .so_far = parts.so_far,
      .interlocks = watch,
      // A camera that is opened anew draws anew.
      .draw =
          [&](std::uint64_t number) {
            if (rig.draw) rig.draw(number);
          },
      .reopen = [&](FailureClass failure) { return ReopenFor(parts, watch, failure); },
      .on_event = [&](const SessionNotice& notice) { notifier.Tell(notice); },
      .on_state = [&](SessionState state) { status.Enter(state); }};
  const SessionStop stop{.after_pose = interrupt.after_pose(),
                         .now = interrupt.now(),
                         .pause = [&] { return interrupt.pausing(); },
                         .wait = [&] { interrupt.WaitWhilePaused(); }};
  const SessionSummary summary =
      RunSession(session, options.session, stop, [&](const Progress& progress) {
        line.Show(progress);
        status.Show(progress);
      });
  status.End(summary);
  return summary;
}

}  // namespace

DriveOptions DriveOptionsOf(const RunOptions& options, const RigConfig& rig) {
  DriveOptions drive;
  drive.session.max_reference_change = options.max_reference_change_percent / 100;
  drive.session.park = options.park;
  drive.notify = options.notify;
  drive.quiet = options.quiet;
  if (options.park && !rig.motion.park) {
    throw ConfigError("--park: the rig file has no motion.park_deg");
  }
  return drive;
}

int DriveSession(const DriveParts& parts, const DriveOptions& options,
                 const std::filesystem::path& dir) {
  const SessionSetup& setup = parts.setup;
  OpenedRig& rig = parts.rig;
  EventLog& log = parts.log;
  if (rig.wires) rig.wires->WriteTo(dir / kWireLog);

  const SessionSummary summary = Measure(parts, options, dir);
  ReportFault(summary, dir);
  if (rig.genicam != nullptr) {
    const std::string frames = TextOf(rig.genicam->counters());
    (void)log.AppendNote(summary.duration, "camera", frames);
    fmt::print("camera           {}\n", frames);
  }
  rig.devices = {};  // stops and switches off: the last words on their wires
  if (rig.wires) {
    RecordWires(*rig.wires, summary, log);
    if (summary.outcome == SessionOutcome::kDeviceFault ||
        summary.outcome == SessionOutcome::kEmergencyStop) {
      fmt::print(stderr, "{}", LastOnTheWires(*rig.wires));
    }
  }
  const int code = ExitCodeOf(summary.outcome);
  // A full disk has no room for a fit either; the samples can be fitted later.
  if (summary.outcome == SessionOutcome::kStorageFailed) return code;
  PrintSession(summary);
  if (!summary.poses.empty()) FitAndPrint(summary, setup, dir);
  fmt::print("wrote            {}\n", dir.string());
  return code;
}

}  // namespace gonio
