// Dates of reports and jobs.
#pragma once

#include <optional>
#include <string>

namespace plumbline::loop {

/// Seconds since 1970-01-01T00:00:00Z of "2026-05-02T08:00:00Z", with a zone (Z, +02:00 or -0530), with or without a
/// fraction of a second (ISO 8601, extended format). None for anything else: without a zone two dates cannot be
/// compared.
std::optional<double> seconds_of(const std::string& date);

}  // namespace plumbline::loop
