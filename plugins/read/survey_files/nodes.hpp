// Nodes from and to survey files; each is an adapter over one function of libraries/survey/files.
#pragma once

#include <string>
#include <string_view>

#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/survey_readings.hpp"
#include "plumbline/node.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::survey_files {

/// What all readers are: one file in, observations out, the reader's findings as warnings.
struct ReaderNode : Node {
  In<File> file{"file", "the survey file"};
  Out<SurveyObservations> observations{"observations", frame("frame=building"),
                                       "normalised observations; what could not be used is listed in `skipped`"};

  Param<bool> strict{"strict", false, "refuse a file of which anything has to be skipped; otherwise it is listed"};

  std::string_view bytes() const;
  std::string name() const { return file->name()->str(); }
  /// Commits, and warns of what was skipped; throws if anything was and `strict` is set.
  void deliver(Context& context, const survey::SurveyObservations& survey) const;
};

struct ReadGsi : ReaderNode {
  static constexpr Info info{"read.gsi", "survey_reader", 1, "Reads Leica GSI-8 and GSI-16"};
  Param<std::string> station_code{"station_code", "21", "value of word 41 that begins a set-up"};
  Param<int64_t> station_word{"station_word", 42, between(42, 49), "word of the code block with the station's name"};
  Param<int64_t> height_word{"height_word", 43, between(42, 49), "word of the code block with the instrument height"};
  Param<double> height_unit{"height_unit", 0.001, "m", between(1e-5, 1), "unit of that height"};
  Param<std::string> vertical_reference{"vertical_reference", "zenith", one_of("zenith", "horizon", "percent"),
                                        "what vertical angles count from; the file does not say"};
  Param<std::string> foot{"foot", "international", one_of("international", "us_survey"), "what a foot is"};
  void run(Context& context) override;
};

struct ReadLandXml : ReaderNode {
  static constexpr Info info{"read.landxml", "survey_reader", 1, "Reads LandXML 1.2 survey data and Leica HeXML"};
  void run(Context& context) override;
};

struct ReadJobXml : ReaderNode {
  static constexpr Info info{"read.jobxml", "survey_reader", 1, "Reads Trimble JobXML"};
  void run(Context& context) override;
};

struct ReadSdr33 : ReaderNode {
  static constexpr Info info{"read.sdr33", "survey_reader", 1, "Reads Sokkia SDR33 and SDR2x"};
  void run(Context& context) override;
};

struct ReadRw5 : ReaderNode {
  static constexpr Info info{"read.rw5", "survey_reader", 1, "Reads Carlson RW5"};
  void run(Context& context) override;
};

struct ReadZeiss : ReaderNode {
  static constexpr Info info{"read.zeiss", "survey_reader", 1,
                             "Reads Zeiss and Trimble M5, R5 and R4: total stations and digital levels"};
  void run(Context& context) override;
};

struct ReadNikon : ReaderNode {
  static constexpr Info info{"read.nikon", "survey_reader", 1,
                             "Reads Nikon RAW, also of Ruide, Spectra and Trimble M3"};
  void run(Context& context) override;
};

struct ReadTopconGts7 : ReaderNode {
  static constexpr Info info{"read.topcon_gts7", "survey_reader", 1, "Reads Topcon GTS-7 and South NTS"};
  void run(Context& context) override;
};

struct ReadTopconGts210 : ReaderNode {
  static constexpr Info info{"read.topcon_gts210", "survey_reader", 1, "Reads Topcon GTS-210 streams"};
  void run(Context& context) override;
};

struct ReadTopconLevel : ReaderNode {
  static constexpr Info info{"read.topcon_dl", "survey_reader", 1, "Reads Topcon DL and Sokkia SDL digital levels"};
  void run(Context& context) override;
};

struct ReadGeodimeter : ReaderNode {
  static constexpr Info info{"read.geodimeter", "survey_reader", 1, "Reads Geodimeter JOB and ARE"};
  void run(Context& context) override;
};

struct ReadIdx : ReaderNode {
  static constexpr Info info{"read.idx", "survey_reader", 2, "Reads Leica IDX"};
  void run(Context& context) override;
};

struct ReadStarNet : ReaderNode {
  static constexpr Info info{"read.starnet", "survey_reader", 1, "Reads STAR*NET data files"};
  void run(Context& context) override;
};

struct ReadDynaMl : ReaderNode {
  static constexpr Info info{"read.dynaml", "survey_reader", 1,
                             "Reads DynaML: stations and terrestrial measurements of DynAdjust"};
  void run(Context& context) override;
};

struct ReadGama : ReaderNode {
  static constexpr Info info{"read.gama", "survey_reader", 1, "Reads the XML networks of gama-local"};
  void run(Context& context) override;
};

struct ReadKrumm : ReaderNode {
  static constexpr Info info{"read.krumm", "survey_reader", 1, "Reads the .dat networks of F. Krumm's examples"};
  void run(Context& context) override;
};

/// What the tables in CSV share.
struct TableReaderNode : ReaderNode {
  Param<std::string> columns{
      "columns", "", "order of the columns of a table without header: letters as in PENZD, or names with commas"};
  Param<std::string> length_unit{"length_unit", "automatic", one_of("automatic", "m", "cm", "mm", "ft", "usft"),
                                 "of length columns whose header names none; automatic: metres, and that is said"};
};

struct ReadSurveyCsv : TableReaderNode {
  static constexpr Info info{"read.survey_csv", "survey_reader", 2, "Reads tables of points or sightings in CSV"};
  Param<std::string> angle_unit{"angle_unit", "automatic", one_of("automatic", "gon", "deg", "dms", "rad"),
                                "of angle columns whose header names none; automatic: what both faces or reciprocal "
                                "zenith angles tell, else the table is refused"};
  void run(Context& context) override;
};

struct ReadSetupCoordinates : TableReaderNode {
  static constexpr Info info{"read.setup_coordinates", "survey_reader", 3,
                             "Reads coordinates in the frame of each set-up, with covariance, from CSV"};
  void run(Context& context) override;
};

struct ReadSurvey : ReaderNode {
  static constexpr Info info{"read.survey", "survey_reader", 2,
                             "Reads a survey file of any format, found from its content, or takes it from a reader of "
                             "another plugin"};
  Param<std::string> angle_unit{"angle_unit", "automatic", one_of("automatic", "gon", "deg", "dms", "rad"),
                                "of a table whose header names none, as in read.survey_csv"};
  Optional<SurveyReadings> readings{"readings", frame("frame=building"),
                                    "files that readers of other plugins have read; this one is taken from there"};
  void run(Context& context) override;
};

/// What all writers are.
struct WriterNode : Node {
  In<SurveyObservations> observations{"observations", frame("frame=?S"), "observations of any source"};
  Optional<Points> points{"points", frame("frame=?S"),
                          "coordinates for points that have none in the file, e.g. adjusted ones"};
  Out<File> file{"file", "the written file"};
  /// The observations, with the coordinates of `points` where they had none.
  survey::SurveyObservations survey_to_write() const;
  void deliver(const std::string& name, const char* media_type, const std::string& content) const;
};

struct WriteGsi : WriterNode {
  static constexpr Info info{"write.gsi", "survey_writer", 1, "Writes Leica GSI-16"};
  Param<std::string> station_start{"station_start", "code_block", one_of("code_block", "station_coordinates"),
                                   "how a set-up begins: words 41 to 43, or 84 to 88"};
  Param<std::string> resolution{"resolution", "0.01 mm", one_of("1 mm", "0.1 mm", "0.01 mm"), "of lengths"};
  void run(Context& context) override;
};

struct WriteGama : WriterNode {
  static constexpr Info info{
      "write.gama", "survey_writer", 1,
      "Writes GNU Gama's gama-local XML; readings in face 2 become those of face 1. Coordinates given "
      "in `points` carry a free network's datum if no point is held"};
  Param<double> direction_sigma{"direction_sigma", 1.5, "mgon", between(1e-6, 1e3),
                                "of directions and angles without one"};
  Param<double> zenith_angle_sigma{"zenith_angle_sigma", 1.5, "mgon", between(1e-6, 1e3),
                                   "of zenith angles without one"};
  Param<double> distance_sigma{"distance_sigma", 2.0, "mm", between(1e-6, 1e6), "of lengths without one"};
  void run(Context& context) override;
};

struct WriteLandXml : WriterNode {
  static constexpr Info info{"write.landxml", "survey_writer", 1, "Writes LandXML 1.2 survey data"};
  void run(Context& context) override;
};

struct WriteStarNet : WriterNode {
  static constexpr Info info{"write.starnet", "survey_writer", 1,
                             "Writes a STAR*NET data file; readings in face 2 become those of face 1"};
  void run(Context& context) override;
};

struct WriteSurveyCsv : WriterNode {
  static constexpr Info info{"write.survey_csv", "survey_writer", 1,
                             "Writes points, set-ups and observations as one CSV table"};
  void run(Context& context) override;
};

}  // namespace plumbline::survey_files
