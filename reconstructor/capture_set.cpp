// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture_set.h"

#include <memory>
#include <set>
#include <vector>

#include "common/datasets/dataset.h"
#include "common/log.h"
#include "common/session.h"

namespace sheen {

CaptureSet open_capture_set(const std::filesystem::path& folder) {
  if (Session::exists(folder)) {
    auto session = std::make_shared<Session>(Session::open_read_only(folder));
    const std::set<std::uint64_t> withdrawn = session->withdrawn();
    std::vector<std::uint64_t> kept;
    std::size_t damaged = 0;
    for (std::uint64_t i = 0; i < session->size(); ++i) {
      if (withdrawn.contains(i)) continue;
      try {
        session->check(i);
        kept.push_back(i);
      } catch (const DamagedCapture& error) {
        log_error("session", std::string("left out: ") + error.what());
        ++damaged;
      }
    }
    const auto read = [session, kept](std::size_t i) { return session->read(kept[i]); };
    return {.size = kept.size(), .withdrawn = withdrawn.size(), .damaged = damaged, .read = read};
  }
  auto dataset = std::make_shared<Dataset>(load_dataset(folder));
  return {.size = dataset->views.size(), .read = [dataset](std::size_t i) { return read_capture(*dataset, i); }};
}

}  // namespace sheen
