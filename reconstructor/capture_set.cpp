// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture_set.h"

#include <memory>

#include "common/datasets/dataset.h"
#include "common/session.h"

namespace sheen {

CaptureSet open_capture_set(const std::filesystem::path& folder) {
  if (Session::exists(folder)) {
    auto session = std::make_shared<Session>(Session::open_read_only(folder));
    return {session->size(), [session](std::size_t i) { return session->read(i); }};
  }
  auto dataset = std::make_shared<Dataset>(load_dataset(folder));
  return {dataset->views.size(), [dataset](std::size_t i) { return read_capture(*dataset, i); }};
}

}  // namespace sheen
