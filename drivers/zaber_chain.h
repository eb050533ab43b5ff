// SPDX-License-Identifier: Apache-2.0
// The Zaber devices on one serial line.

#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/byte_link.h"
#include "drivers/line_reader.h"
#include "drivers/zaber_codec.h"

namespace gonio::zaber {

// Asks one question at a time, for all the axes on its line. A reply belongs to the command with
// its id, device and axis: late ones, alerts and info are passed over. Any thread.
class Chain {
 public:
  // Zaber's own library waits that long.
  static constexpr Seconds kReplyLimit{1};

  explicit Chain(std::unique_ptr<ByteLink> link, Seconds reply_limit = kReplyLimit);

  const std::string& name() const { return link_->name(); }
  // Data of the reply to a query, which is asked again if the reply does not come or is garbled:
  // asking twice does no harm. kRefused: the device rejected it.
  Result<Message> Query(int device, int axis, const std::string& data);
  // The reply to a command. Sent once: after kTimeout or kProtocol nobody knows whether it was
  // heard.
  Result<Message> Command(int device, int axis, const std::string& data);

 private:
  Result<Message> Exchange(int device, int axis, const std::string& data);
  Error About(int device, int axis, const std::string& data, const Error& error) const;

  std::mutex mutex_;
  std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  Seconds reply_limit_;
  int last_id_ = 0;
};

}  // namespace gonio::zaber
