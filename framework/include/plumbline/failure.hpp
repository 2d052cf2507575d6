// Why a node has no result, as types: the program tells them apart, in records and by its exit code, without reading
// sentences. What() is for people all the same: what was found, what was expected, where, and what to do.
#pragma once

#include <stdexcept>
#include <string>

#include "plumbline/plugin.h"

namespace plumbline {

/// A failure with its kind. Other exceptions count as plain failures; Stopped (stop.hpp) is none at all.
class Failure : public std::runtime_error {
 public:
  Failure(plumbline_answer kind, const std::string& what) : std::runtime_error(what), kind_(kind) {}
  plumbline_answer kind() const { return kind_; }

 private:
  plumbline_answer kind_;
};

/// What was given cannot be used: a file, a table, a set of observations.
class BadInput : public Failure {
 public:
  explicit BadInput(const std::string& what) : Failure(PLUMBLINE_BAD_INPUT, what) {}
};

/// A solver ended without a result; the input may be sound.
class NotConverged : public Failure {
 public:
  explicit NotConverged(const std::string& what) : Failure(PLUMBLINE_NOT_CONVERGED, what) {}
};

/// Of which kind an error is, for who throws another one in its place that says more.
inline plumbline_answer kind_of(const std::exception& error) {
  const auto* failure = dynamic_cast<const Failure*>(&error);
  return failure ? failure->kind() : PLUMBLINE_FAILED;
}

}  // namespace plumbline
