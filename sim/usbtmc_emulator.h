// SPDX-License-Identifier: Apache-2.0
// A USB test and measurement instrument, as its USB cable sees it.

#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "sim/usb_double.h"

namespace gonio {

enum class UsbtmcFault {
  kSilent,       // takes a message, and its answer never comes
  kLate,         // the answer comes once the next message is in, before the answer to that
  kStallOut,     // halts the pipe towards the device instead of taking a message
  kStallIn,      // halts the pipe from the device instead of sending an answer
  kWrongTag,     // answers another transfer than was asked
  kNoEnd,        // the answer is cut in half: its end comes when asked for more
  kNeverEnds,    // the first half again and again
  kOversize,     // announces 4 GB
  kShort,        // announces more than it sends
  kEmptyFirst,   // begins with a transfer of nothing
  kHeaderFirst,  // the header comes in a transfer of its own
};

// Obeys the rules of the class: headers are checked, a request takes one transfer of at most so
// many bytes, aborts and clears do what they should. Interface 0 is another one, as on instruments
// whose firmware can be exchanged. Written from the class's description and not from our codec. Any
// thread.
class UsbtmcEmulator final : public UsbDouble {
 public:
  // Whole messages, without their line end, to answers; an empty one is none. Answers get a line
  // end.
  using Instrument = std::function<std::string(std::string_view message)>;

  UsbtmcEmulator(UsbPlate plate, Instrument instrument);

  // The next so many answers (messages, of kStallOut) go wrong like this.
  void Inject(UsbtmcFault fault, int times = 1);
  // Refuses the class's aborts, so that only a clear helps.
  void set_refuses_aborts(bool refuses);
  int clears() const;           // how often it was cleared
  int aborts() const;           // how often a transfer was aborted
  std::size_t longest() const;  // message that came in, in bytes

  const UsbPlate& plate() const override { return plate_; }
  std::string Descriptors() const override;
  UsbOutcome Control(const UsbSetup& setup) override;
  UsbOutcome Out(std::string_view bytes) override;
  UsbOutcome In(std::size_t most) override;
  void ClearHalt(std::uint8_t endpoint) override;
  void Reset() override;

 private:
  struct Request {  // for one transfer of an answer
    std::uint8_t tag = 0;
    std::size_t most = 0;
  };

  bool Takes(UsbtmcFault fault);
  bool TakeTransfer();
  void TakeMessage(const std::string& message);
  void AnswerRequest();
  void SendTransfer(const std::string& payload, bool end);
  void Forget();
  std::string AbortIn(std::uint8_t tag);

  const UsbPlate plate_;
  const Instrument instrument_;
  mutable std::mutex mutex_;
  std::optional<UsbtmcFault> fault_;
  int fault_times_ = 0;
  bool refuses_aborts_ = false;
  int clears_ = 0;
  int aborts_ = 0;
  std::size_t longest_ = 0;

  std::string coming_;                 // bytes of a transfer that is not complete
  std::string message_;                // parts of a message that has not ended
  std::deque<std::string> answers_;    // that nobody has fetched, or not all of them
  std::string late_;                   // an answer that is held back
  std::optional<Request> request_;     // that waits for an answer
  std::deque<std::string> transfers_;  // that the host may read
  bool in_halted_ = false;
  bool out_halted_ = false;
};

}  // namespace gonio
