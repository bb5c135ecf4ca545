// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace sheen {

// What the kernel says of a process that runs. Throws Error where it says nothing.

/// What a process, or one of its threads, has had so far, in user and system, also of threads that have ended. `stat`:
/// /proc/PID/stat, or that of a thread.
double processor_seconds(const std::filesystem::path& stat);
double processor_seconds(pid_t process);

double resident_mb(pid_t process);

}  // namespace sheen
