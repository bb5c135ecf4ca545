// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace sheen {

/// Base of everything Sheen throws. Exceptions are for start-up, configuration and files; what can happen to any single
/// frame is a value with a reason (see `PoseStatus`, `IngestReport`). The message says what was wrong, where (file,
/// line, field) and what to do.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file or folder is missing, unreadable, broken or cannot be written.
class FileError : public Error {
 public:
  FileError(const std::string& path, const std::string& what) : Error(path + ": " + what), path_(path) {}
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// A value on the command line or in a configuration file is out of range or contradicts another one.
class ConfigError : public Error {
 public:
  using Error::Error;
};

/// A camera, display or network endpoint cannot be had.
class DeviceError : public Error {
 public:
  using Error::Error;
};

/// A message from a peer or a journal does not hold what it must.
class ProtocolError : public Error {
 public:
  using Error::Error;
};

}  // namespace sheen
