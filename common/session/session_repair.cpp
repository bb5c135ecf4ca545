// SPDX-License-Identifier: Apache-2.0
#include "common/session/session_repair.h"

#include <optional>
#include <set>
#include <utility>

#include "common/capture/capture_validation.h"

namespace sheen {

namespace fs = std::filesystem;

namespace {

using Identity = std::pair<std::string, std::uint64_t>;  // source session and sequence

constexpr std::uint64_t kLargestStranger = 1'000'000'000'000;  ///< number of a file that the index does not know

/// What is known under one file name.
struct Entry {
  std::optional<IndexRow> row;
  std::optional<std::uintmax_t> bytes;  ///< of the file, if it is there
};

/// Adds up what happened to several captures and names the first.
class Finding {
 public:
  explicit Finding(std::string what) : what_(std::move(what)) {}
  void add(const std::string& example) {
    if (count_++ == 0) first_ = example;
  }
  void tell(std::vector<std::string>& lines) const {
    if (count_ == 0) return;
    lines.push_back(std::to_string(count_) + (count_ == 1 ? " capture " : " captures ") + what_ +
                    (count_ == 1 ? ": " : ", the first: ") + first_);
  }

 private:
  std::string what_, first_;
  std::size_t count_ = 0;
};

std::map<std::string, std::uintmax_t> capture_files(const fs::path& folder) {
  std::map<std::string, std::uintmax_t> files;
  std::error_code error;
  for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
    const std::string name = i->path().filename().string();
    std::error_code no_size;
    if (capture_file_number(name) && i->is_regular_file(no_size)) {
      const std::uintmax_t bytes = i->file_size(no_size);
      files[name] = no_size ? 0 : bytes;
    }
  }
  return files;
}

bool makes_sense(const IndexRow& row) {
  return row.sane && capture_file_number(row.file.name) && is_plain_text(row.source_session);
}

std::string free_name(const fs::path& folder, const std::string& wanted) {
  std::string name = wanted;
  for (int n = 2; fs::exists(folder / name); ++n) name = wanted + "-" + std::to_string(n);
  return name;
}

class Planner {
 public:
  Planner(const IndexContents& index, const fs::path& captures) : index_(index), folder_(captures) {
    for (const auto& [name, bytes] : capture_files(captures)) entries_[*capture_file_number(name)].bytes = bytes;
    for (const IndexRow& row : index.rows) {
      if (!makes_sense(row))
        dropped_.add("row " + std::to_string(static_cast<std::int64_t>(row.index)));
      else if (std::optional<IndexRow>& known = entries_[*capture_file_number(row.file.name)].row; !known)
        known = row;
    }
  }

  SessionRepair plan() {
    // Rows whose files are there go first: a copy of theirs is a copy, whatever its number.
    for (auto& [number, entry] : entries_)
      if (entry.row && entry.bytes == entry.row->file.bytes) take(number, *entry.row);
    for (auto& [number, entry] : entries_)
      if (entry.bytes && !(entry.row && entry.bytes == entry.row->file.bytes)) look_into(number, entry);
    for (auto& [number, entry] : entries_)
      if (entry.row && !entry.bytes) keep_without_file(number, *entry.row);
    renumber();
    for (const Finding& finding : {added_, mended_, damaged_, missing_, aside_, dropped_})
      finding.tell(repair_.findings);
    return std::move(repair_);
  }

 private:
  bool take(std::uint64_t number, const IndexRow& row) {
    if (!known_.insert({row.source_session, row.sequence}).second) return false;
    taken_[number] = row;
    return true;
  }

  /// A file of which the index knows nothing, or something else.
  void look_into(std::uint64_t number, const Entry& entry) {
    const std::string name = entry.row ? entry.row->file.name : capture_file_name(number);
    const std::string path = (folder_ / name).string();
    if (!entry.row && number > kLargestStranger) return;
    try {
      const FoundCapture found = identify_capture_file(folder_, name);
      if (take(number, {0, found.source_session, found.sequence, found.file}))
        return (entry.row ? mended_ : added_).add(path);
      set_aside(name, ".duplicate", "is a copy of " + found.source_session + " " + std::to_string(found.sequence));
    } catch (const FileError& error) {
      if (entry.row && take(number, *entry.row)) return damaged_.add(error.what());
      set_aside(name, ".damaged", error.what());
    }
  }

  void keep_without_file(std::uint64_t number, const IndexRow& row) {
    if (take(number, row)) missing_.add((folder_ / row.file.name).string());
  }

  void set_aside(const std::string& name, const char* suffix, const std::string& why) {
    const std::string to = free_name(folder_, name + suffix);
    repair_.set_aside[name] = to;
    aside_.add((folder_ / to).string() + " (" + why + ")");
  }

  /// Indices count from 0 in the order of the files' numbers; marks follow their captures.
  void renumber() {
    IndexContents& contents = repair_.contents;
    std::map<Identity, std::uint64_t> place;
    for (auto& [number, row] : taken_) {
      row.index = contents.rows.size();
      place[{row.source_session, row.sequence}] = row.index;
      contents.rows.push_back(row);
    }
    std::map<std::uint64_t, std::uint64_t> moved;  // from the old index to the new one
    for (const IndexRow& row : index_.rows)
      if (const auto to = place.find({row.source_session, row.sequence}); to != place.end())
        moved[row.index] = to->second;
    for (Withdrawal entry : index_.withdrawals) {
      if (const auto to = moved.find(entry.capture); to != moved.end()) {
        entry.capture = to->second;
        contents.withdrawals.push_back(entry);
      } else {
        dropped_.add("mark " + std::to_string(entry.number) + ", of capture " +
                     std::to_string(static_cast<std::int64_t>(entry.capture)));
      }
    }
    contents.metadata = index_.metadata;
    repair_.changed = contents.rows != index_.rows || contents.withdrawals.size() != index_.withdrawals.size();
  }

  const IndexContents& index_;
  const fs::path folder_;
  std::map<std::uint64_t, Entry> entries_;  ///< by file number
  std::map<std::uint64_t, IndexRow> taken_;
  std::set<Identity> known_;
  SessionRepair repair_;
  Finding added_{"missing from the index, added from the files"},
      mended_{"with a wrong index entry, read from the file again"},
      damaged_{"damaged; put back a copy of the file, or withdraw it with undo"},
      missing_{"without a file; put the file back, or withdraw it with undo"}, aside_{"set aside"},
      dropped_{"that never existed, dropped from the index"};
};

}  // namespace

SessionRepair plan_repair(const IndexContents& index, const fs::path& captures) {
  return Planner(index, captures).plan();
}

bool has_capture_files(const fs::path& captures) {
  return !capture_files(captures).empty();
}

}  // namespace sheen
