// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/interruptible.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <future>
#include <thread>

#include "common/base/guarded_thread.h"
#include "common/base/stop_signal.h"

namespace sheen {
namespace {

namespace py = pybind11;

constexpr std::chrono::milliseconds kLook{50};

}  // namespace

void interruptible(const std::function<void()>& work) {
  std::promise<void> end;
  const std::future<void> ended = end.get_future();
  std::exception_ptr error;
  const std::jthread worker = guarded_thread(
      [&] {
        work();
        end.set_value();
      },
      [&](const std::exception_ptr& thrown) {
        error = thrown;
        end.set_value();
      });
  const auto wait = [&](std::chrono::milliseconds time) {
    const py::gil_scoped_release others_run;
    return ended.wait_for(time) == std::future_status::ready;
  };
  while (!wait(kLook)) {
    if (PyErr_CheckSignals() == 0) continue;
    const py::error_already_set interrupt;
    count_stop_signal();
    while (!wait(kLook)) {
    }
    forget_stop_signals();
    throw interrupt;
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace sheen
