// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "core/check.h"
#include "drivers/deadline.h"
#include "drivers/genicam_link.h"

namespace gonio {
namespace {

constexpr Seconds kLeastMargin{0.3};
constexpr Seconds kBetweenTries{0.2};  // to find a lost camera
// A register takes 2.5 s of a camera that does not answer; so many of them in a row, at most.
constexpr Seconds kSilence{12};
// Clocks of cameras run fast or slow by less.
constexpr double kClockTolerance = 1e-3;
// What a frame says of itself may differ by so much from what the camera read back: it may round
// one of them to 1 us.
constexpr double kExposureTolerance = 1e-3;  // relative
constexpr Seconds kExposureStep{1e-6};
constexpr double kGainTolerance = 0.05;  // dB
constexpr int kMostLate = 4;             // frames in a row that may have earlier settings

// What Capture() asks of the camera's thread.
struct Request {
  Request(Seconds time, Seconds limit) : exposure(time), deadline(limit) {}
  const Seconds exposure;
  const Deadline deadline;
  std::atomic<bool> abandoned = false;
  std::optional<Result<Frame>> answer;  // under the mutex
};

}  // namespace

class GenicamCamera::Impl {
 public:
  Impl(const GenicamSettings& settings, Clock& clock) : settings_(settings), clock_(clock) {}

  Result<void> Open();
  Result<Frame> Capture(Seconds exposure, std::stop_token stop);
  Seconds FrameLimit(Seconds exposure) const;
  Seconds CaptureLimit(Seconds exposure) const;
  GenicamCounters counters();
  Error Named(const Error& error) const {
    return {error.code, fmt::format("{}: {}", settings_.name, error.message)};
  }

  const GenicamSettings settings_;
  CameraInfo info_;
  std::string identity_;

 private:
  using Lock = std::unique_lock<std::mutex>;

  // The camera's thread: all that follows until the next blank line.
  void Run(std::stop_token quit);
  Result<Frame> Serve(Request& request);
  Result<Frame> Attempt(Request& request);
  Result<Frame> TakeOne(Request& request);
  bool IsAsSet(const Frame& frame) const;
  Result<void> Reopen(Request& request);
  Result<void> SetExposure(Seconds exposure);
  // What is to be done about a frame that did not come.
  Error Missed(const Error& error);
  void Drop();
  template <typename Change>
  void Count(Change change);

  Clock& clock_;
  std::unique_ptr<GenicamLink> link_;
  Seconds asked_{0};    // the exposure that was set
  Seconds used_{0};     // what the camera made of it
  Seconds longest_{0};  // that a frame to come may take: earlier settings may still be in force
  int untrusted_ = 0;   // frames to come that are thrown away
  std::stop_token quit_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::shared_ptr<Request> request_;  // null: the thread is idle
  std::optional<Result<void>> opened_;
  GenicamCounters counters_;
  std::jthread thread_;  // last: it ends before what it uses
};

Result<void> GenicamCamera::Impl::Open() {
  const int ways =
      !settings_.address.empty() + !settings_.serial.empty() + !settings_.device_id.empty();
  GONIO_CHECK(ways == 1, "a camera is found in exactly one way");
  GONIO_CHECK(settings_.margin >= kLeastMargin, "cameras may take 0.3 s longer");
  thread_ = std::jthread([this](std::stop_token quit) { Run(quit); });
  Lock lock(mutex_);
  changed_.wait(lock, [&] { return opened_.has_value(); });
  return *opened_;
}

Seconds GenicamCamera::Impl::FrameLimit(Seconds exposure) const {
  return exposure + info_.readout + settings_.margin;
}

Seconds GenicamCamera::Impl::CaptureLimit(Seconds exposure) const {
  const int discarded = std::max(settings_.discarded_first, settings_.discarded_on_change);
  return (1 + settings_.retries) * (1 + discarded) * FrameLimit(exposure) + settings_.reopen_limit +
         kSilence;
}

GenicamCounters GenicamCamera::Impl::counters() {
  const Lock lock(mutex_);
  return counters_;
}

template <typename Change>
void GenicamCamera::Impl::Count(Change change) {
  const Lock lock(mutex_);
  change(counters_);
}

Result<Frame> GenicamCamera::Impl::Capture(Seconds exposure, std::stop_token stop) {
  // Also true of NaN.
  if (!(exposure >= info_.min_exposure && exposure <= info_.max_exposure)) {
    return Error{
        ErrorCode::kRefused,
        fmt::format("an exposure of {:.6g} s is outside {:.6g} .. {:.6g} s", exposure.count(),
                    info_.min_exposure.count(), info_.max_exposure.count())};
  }
  const Error cancelled{ErrorCode::kCancelled, "the exposure was cancelled"};
  if (stop.stop_requested()) return cancelled;
  const auto request = std::make_shared<Request>(exposure, CaptureLimit(exposure));
  const auto end =
      std::chrono::steady_clock::now() +
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(request->deadline.limit());
  Lock lock(mutex_);
  // It may still be busy with one that was given up.
  if (changed_.wait_until(lock, stop, end, [&] { return !request_; })) {
    request_ = request;
    changed_.notify_all();
    changed_.wait_until(lock, stop, end, [&] { return request->answer.has_value(); });
    if (request->answer) return *std::move(request->answer);
    request->abandoned = true;
  }
  if (stop.stop_requested()) return cancelled;
  return Error{ErrorCode::kTimeout, fmt::format("nothing was heard from the camera for {:.3g} s",
                                                request->deadline.limit().count())};
}

void GenicamCamera::Impl::Run(std::stop_token quit) {
  quit_ = quit;
  auto link = GenicamLink::Open(settings_);
  Result<void> opened;
  if (link) {
    link_ = std::move(link).value();
    info_ = link_->info();
    identity_ = link_->identity();
    untrusted_ = settings_.discarded_first;
  } else {
    opened = link.error();
  }
  Lock lock(mutex_);
  opened_ = opened;
  changed_.notify_all();
  while (changed_.wait(lock, quit, [&] { return request_ != nullptr; })) {
    const auto request = request_;
    lock.unlock();
    auto answer = Serve(*request);
    lock.lock();
    if (answer) ++counters_.frames;
    request->answer = std::move(answer);
    request_ = nullptr;
    changed_.notify_all();
  }
  lock.unlock();
  link_.reset();
}

Result<Frame> GenicamCamera::Impl::Serve(Request& request) {
  for (int attempt = 0;; ++attempt) {
    if (!link_ || link_->lost()) {
      if (const auto found = Reopen(request); !found) return found.error();
    }
    auto frame = Attempt(request);
    if (frame) return frame;
    const Error& error = frame.error();
    if (error.code == ErrorCode::kDisconnected) Drop();
    const bool again = error.code == ErrorCode::kTimeout || error.code == ErrorCode::kProtocol ||
                       error.code == ErrorCode::kDisconnected;
    if (!again || attempt >= settings_.retries || request.deadline.Left() == Seconds(0)) {
      return Error{error.code, attempt == 0
                                   ? error.message
                                   : fmt::format("{} ({} tries)", error.message, attempt + 1)};
    }
    Count([](GenicamCounters& counters) { ++counters.retries; });
  }
}

Result<Frame> GenicamCamera::Impl::Attempt(Request& request) {
  if (const auto set = SetExposure(request.exposure); !set) return set.error();
  for (; untrusted_ > 0; --untrusted_) {
    const auto thrown = TakeOne(request);
    if (!thrown && thrown.error().code != ErrorCode::kProtocol) return thrown.error();
    Count([](GenicamCounters& counters) { ++counters.discarded; });
  }
  for (int late = 0;; ++late) {
    auto frame = TakeOne(request);
    if (!frame) return frame;
    if (IsAsSet(*frame)) {
      longest_ = used_;
      return frame;
    }
    if (late == kMostLate) {
      return Error{
          ErrorCode::kProtocol,
          fmt::format("frames are taken with {:.6g} s and {:.4g} dB, but the camera is set "
                      "to {:.6g} s and {:.4g} dB",
                      frame->exposure.count(), frame->gain_db, used_.count(), link_->gain_db())};
    }
    Count([](GenicamCounters& counters) { ++counters.late; });
  }
}

bool GenicamCamera::Impl::IsAsSet(const Frame& frame) const {
  const Seconds off = frame.exposure > used_ ? frame.exposure - used_ : used_ - frame.exposure;
  return off <= std::max(kExposureStep, kExposureTolerance * used_) &&
         std::abs(frame.gain_db - link_->gain_db()) <= kGainTolerance;
}

Result<void> GenicamCamera::Impl::SetExposure(Seconds exposure) {
  if (exposure == asked_) return {};
  asked_ = Seconds(0);  // not known, should it fail
  const auto used = link_->SetExposure(exposure);
  if (!used) return used.error();
  asked_ = exposure;
  used_ = *used;
  longest_ = std::max(longest_, used_);
  if (!link_->tells_exposure()) untrusted_ = std::max(untrusted_, settings_.discarded_on_change);
  return {};
}

Result<Frame> GenicamCamera::Impl::TakeOne(Request& request) {
  const bool software = settings_.trigger_line.empty();
  const auto abandoned = [&] { return request.abandoned || quit_.stop_requested(); };
  link_->DropImages();
  const Seconds asked = clock_.Now();
  if (software) {
    if (const auto triggered = link_->Trigger(); !triggered) return triggered.error();
  }
  const Deadline deadline(std::min(FrameLimit(longest_), request.deadline.Left()));
  std::map<std::string, int> bad;
  auto image = link_->WaitForImage(deadline, abandoned, bad);
  // An edge may have come before the call, and its frame after it.
  while (image && !software &&
         clock_.Now() - (1 - kClockTolerance) * image->exposure.value_or(used_) < asked) {
    image = link_->WaitForImage(deadline, abandoned, bad);
  }
  Count([&](GenicamCounters& counters) {
    for (const auto& [what, count] : bad) counters.bad[what] += count;
  });
  if (!image) return Missed(image.error());
  Frame frame;
  frame.width = info_.width;
  frame.height = info_.height;
  frame.layout = info_.layout;
  frame.counts = std::move(image->counts);
  frame.exposure = image->exposure.value_or(used_);
  frame.gain_db = image->gain_db.value_or(link_->gain_db());
  frame.black_level = link_->black_level();
  // The edge's time is not known, only when its frame was there.
  const Seconds latest = clock_.Now() - frame.exposure;
  frame.start = software ? asked : std::max(asked, latest - info_.readout);
  const auto temperature = link_->Temperature();
  if (temperature) frame.temperature_c = *temperature;
  return frame;
}

Error GenicamCamera::Impl::Missed(const Error& error) {
  if (error.code != ErrorCode::kTimeout && error.code != ErrorCode::kCancelled) return error;
  // What is still being exposed must not be taken for the next frame.
  auto well = error.code == ErrorCode::kTimeout ? link_->CheckAlive() : Result<void>();
  if (well) well = link_->Restart();
  untrusted_ = std::max(untrusted_, settings_.discarded_first);
  if (well) return error;
  if (error.code == ErrorCode::kCancelled) {
    Drop();
    return error;
  }
  return {ErrorCode::kDisconnected, fmt::format("{}, and {}", error.message, well.error().message)};
}

void GenicamCamera::Impl::Drop() {
  if (link_) link_->GiveUp();
  link_.reset();
}

Result<void> GenicamCamera::Impl::Reopen(Request& request) {
  Drop();
  const Deadline limit(std::min(settings_.reopen_limit, request.deadline.Left()));
  std::string reason;
  do {
    auto link = GenicamLink::Open(settings_);
    // What it is, and every setting that it read back.
    if (link && (*link)->identity() != identity_) {
      return Error{ErrorCode::kProtocol, fmt::format("in its place was found: {}; it was: {}",
                                                     (*link)->identity(), identity_)};
    }
    if (link) {
      link_ = std::move(link).value();
      asked_ = longest_ = Seconds(0);
      untrusted_ = settings_.discarded_first;
      Count([](GenicamCounters& counters) { ++counters.reopened; });
      return {};
    }
    reason = link.error().message;
    Lock lock(mutex_);
    changed_.wait_for(lock, quit_, kBetweenTries, [&] { return request.abandoned.load(); });
    if (request.abandoned || quit_.stop_requested()) {
      return Error{ErrorCode::kCancelled, "the search for the camera was ended"};
    }
  } while (limit.Left() > Seconds(0));
  return Error{ErrorCode::kDisconnected,
               fmt::format("the camera was lost and not found again for {:.3g} s: {}",
                           limit.limit().count(), reason)};
}

GenicamCamera::GenicamCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GenicamCamera::~GenicamCamera() = default;

Result<std::unique_ptr<GenicamCamera>> GenicamCamera::Open(const GenicamSettings& settings,
                                                           Clock& clock) {
  auto impl = std::make_unique<Impl>(settings, clock);
  if (const auto opened = impl->Open(); !opened) return impl->Named(opened.error());
  return std::unique_ptr<GenicamCamera>(new GenicamCamera(std::move(impl)));
}

const std::string& GenicamCamera::name() const { return impl_->settings_.name; }
const std::string& GenicamCamera::identity() const { return impl_->identity_; }
const CameraInfo& GenicamCamera::info() const { return impl_->info_; }
GenicamCounters GenicamCamera::counters() const { return impl_->counters(); }
Seconds GenicamCamera::CaptureLimit(Seconds exposure) const {
  return impl_->CaptureLimit(exposure);
}

Result<Frame> GenicamCamera::Capture(Seconds exposure, std::stop_token stop) {
  auto frame = impl_->Capture(exposure, std::move(stop));
  if (!frame) return impl_->Named(frame.error());
  return frame;
}

}  // namespace gonio
