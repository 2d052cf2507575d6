// A series of epochs as files.
#pragma once

#include <string>
#include <vector>

#include "survey/epochs/epoch_series.hpp"

namespace plumbline::survey {

struct SeriesText {
  std::string unit;                 ///< of time: "day", or "epoch"
  std::vector<std::string> labels;  ///< one per epoch
  std::vector<double> times;        ///< likewise
  SeriesOptions options;
  std::vector<std::string> notes;  ///< scale and temperature, as size_notes() has them
  bool is_explained = false;       ///< a mistake in an epoch, in `notes`, would be such movements
};

/// A velocity as people read it: per year where time is in days.
double velocity_factor(const SeriesText& text);
std::string velocity_unit(const SeriesText& text);

/// "M7: moves, H -14.6 mm/year (sigma 0.9)"; empty if nothing is to be said of the point.
std::string in_words(const SeriesPoint& point, const SeriesText& text);
/// The same without the point's name.
std::string told_of(const SeriesPoint& point, const SeriesText& text);
/// Points of which something is to be said, alarms and what moves fastest first; the others in `quiet`.
std::vector<const SeriesPoint*> points_told(const EpochSeries& series, const SeriesText& text,
                                            std::vector<const SeriesPoint*>& quiet);
/// Sentences of page and verdict: which epochs in which order, how many points are told, and which carry the datum.
std::string order_words(const SeriesText& text);
std::string how_many_move(std::size_t told, const SeriesText& text);
std::string datum_words(const EpochSeries& series, const SeriesText& text);

std::string series_as_json(const EpochSeries& series, const SeriesText& text);
std::string series_as_csv(const EpochSeries& series, const SeriesText& text);
/// In a few lines: what moves, how good the epochs are, what carries the datum.
std::string series_verdict(const EpochSeries& series, const SeriesText& text);
/// Points that move, moved or reach a level first; a chart for each of them, and of the others where they are few.
std::string series_as_html(const EpochSeries& series, const SeriesText& text);

}  // namespace plumbline::survey
