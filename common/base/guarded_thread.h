// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <stop_token>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace sheen {

/// What an error says, whoever threw it.
std::string words_of(const std::exception_ptr& error) noexcept;

/// Calls `work`, and lets nothing out that it throws: `failed` is given that instead, and what this throws in turn is
/// lost. Whether all went well.
template <typename Work, typename Failed>
bool guarded(Work&& work, Failed&& failed) noexcept {
  try {
    work();
    return true;
  } catch (...) {
    try {
      failed(std::current_exception());
    } catch (...) {  // no memory is left even to tell
    }
  }
  return false;
}

/// Every thread of the programs is made here: an exception that leaves a thread ends the process, and with it a
/// capture. `work` may take the thread's stop token. `failed` takes a std::exception_ptr, on the same thread, and turns
/// it into what others look at: a status, a line of the log, what a later call throws.
template <typename Work, typename Failed>
std::jthread guarded_thread(Work work, Failed failed) {
  return std::jthread([work = std::move(work), failed = std::move(failed)](const std::stop_token& stop) mutable {
    guarded(
        [&] {
          if constexpr (std::is_invocable_v<Work&, const std::stop_token&>)
            work(stop);
          else
            work();
        },
        failed);
  });
}

/// One that nobody waits for, since it may hang in a library.
template <typename Work, typename Failed>
void detached_thread(Work work, Failed failed) {
  std::thread([work = std::move(work), failed = std::move(failed)]() mutable { guarded(work, failed); }).detach();
}

}  // namespace sheen
