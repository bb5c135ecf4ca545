// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "common/link/wire.h"
#include "common/session/session_types.h"

namespace sheen {

/// Journal of a capture: a folder with `session.sqlite` (index, metadata) and one file per capture in `captures/` (the
/// wire encoding, lossless). A capture is durable when `append` returns: its file is flushed to the disk. Its row
/// in the index follows with others; where a power cut takes rows, the files give them back.
/// One writer at a time (locked). A capture can be withdrawn: it stays, marked, and models leave it out. Readers may
/// withdraw beside the writer.
///
/// Opening deletes nothing. What the index does not know is ingested from the capture files, each of which says whose
/// it is (session_repair.h); whoever only reads does so in memory. What was found is logged, and told by `diagnosis`.
class Session {
 public:
  static Session create(const std::filesystem::path& folder);  ///< throws FileError; the folder may exist if empty
  static Session open(const std::filesystem::path& folder);    ///< for appending; throws FileError
  static Session open_read_only(const std::filesystem::path& folder);  ///< throws FileError
  /// For reading and for withdrawing, also while another program writes. Throws FileError.
  static Session open_to_withdraw(const std::filesystem::path& folder);
  /// An index, or captures that have lost theirs.
  static bool exists(const std::filesystem::path& folder);
  Session(Session&&) noexcept;
  ~Session();

  /// Appends and flushes; returns the capture's index. A (source_session, sequence) that is there already returns the
  /// index it has, or throws TakenName where that one has another image or mask. Nobody else waits meanwhile, whether
  /// to read or to take back. Throws FileError, a full disk included, and within a second SessionBusy: then the same
  /// capture may be appended again; the session stays usable and consistent.
  std::uint64_t append(const Capture& capture);
  std::uint64_t size() const;
  /// Throws DamagedCapture naming the file when it is missing or its checksum is wrong.
  Capture read(std::uint64_t index) const;
  /// Throws what `read` would, but unpacks nothing.
  void check(std::uint64_t index) const;
  /// Reads no pixels. Throws DamagedCapture when not even the label can be read.
  CaptureLabel label(std::uint64_t index) const;
  /// Per source session: the highest sequence that is durable without a gap before it.
  std::map<std::string, std::uint64_t> held() const;

  /// Takes a capture back, or puts it back; durable when it returns. False when it was so already. Throws FileError
  /// when there is no such capture.
  bool set_withdrawn(std::uint64_t index, bool withdrawn);
  std::set<std::uint64_t> withdrawn() const;
  /// The entries after a number, in their order: what a reader that knows of the earlier ones has missed.
  std::vector<Withdrawal> withdrawals_after(std::uint64_t number) const;
  /// The last capture that is not withdrawn.
  std::optional<std::uint64_t> last() const;

  /// Small text values: the mesh's path and hash, the model's configuration, tool versions.
  void set_metadata(const std::string& key, const std::string& value);
  std::optional<std::string> metadata(const std::string& key) const;

  /// What opening found wrong and what it did about it, one line each; empty for a sound session.
  const std::vector<std::string>& diagnosis() const;

 private:
  struct Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
