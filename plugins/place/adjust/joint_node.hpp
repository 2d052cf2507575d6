// adjust.joint: readings of total stations and photographs of marker plates in one adjustment.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/control_artifact.hpp"
#include "artifacts/frame_artifact.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_observations.hpp"
#include "artifacts/transform.hpp"
#include "photo/joint/joint_adjustment.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/model/several_instruments.hpp"
#include "survey/start/merge_surveys.hpp"
#include "tag_adjuster_node.hpp"

namespace plumbline::block {

struct JointAdjuster : TagAdjusterNode {
  static constexpr Info info{
      "adjust.joint", "", 3,
      "Directions, zenith angles, distances and photographs in one least-squares system; takes readings where "
      "an adjuster takes coordinates, hence the pipelines site_campaign_joint and observations_joint"};
  List<ImageTags> observations{"observations", "tags of every image"};
  In<Poses> poses{"poses", frame("frame=?F"),
                  "approximate poses; images without one are oriented from plates they share"};
  In<Camera> camera{"camera", "interior orientation; its covariance is the prior of a self-calibration"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor, control and check anchors"};
  List<plumbline::SurveyObservations> survey{"survey", frame("frame=?S"),
                                             "readings of one campaign, from one or several files"};
  Optional<Points> known{"known", frame("frame=?S"),
                         "points of the survey known beforehand, with or without covariance"};
  Optional<Transform> frames{"frames", frame("to=?F,from=?S"),
                             "from the survey's frame to that of plates and poses; without it they are one"};

  Param<std::string> datum{"datum", "automatic", one_of("automatic", "file", "fixed", "weighted", "inner"),
                           "what defines the survey's frame, as in survey.adjust"};
  Param<bool> remove_blunders{"remove_blunders", false, "mistakes of the survey are mended first, as in survey.adjust"};
  Param<std::vector<std::string>> exclude{"exclude", std::vector<std::string>{},
                                          "what is left out of the survey and why, as in survey.adjust"};
  Param<std::vector<std::string>> same_stations{"same_stations", std::vector<std::string>{},
                                                "stations that are one mark, as in survey.adjust"};
  Param<std::string> profile{"profile", "automatic",
                             "instrument profile for readings without standard deviation, as in survey.adjust"};
  Param<FilePath> profile_file{"profile_file", FilePath{}, "YAML file of a profile of your own, in its place"};
  Param<bool> estimate_survey_variance{
      "estimate_survey_variance", true,
      "a variance component of all readings, beside that of the images; false: their standard deviations hold"};

  Out<Points> points{"points", frame("frame=?F"), "adjusted anchors with their full marginal covariance"};
  Out<Camera> adjusted_camera{"camera", "interior orientation after the adjustment"};
  Out<Poses> adjusted_poses{"poses", frame("frame=?F"), "exterior orientations with covariance"};
  Out<Block> block{"block", frame("frame=?F"), "statistics, residuals and reliability"};
  Out<Points> survey_points{"survey_points", frame("frame=?S"),
                            "marks and stations of the survey where the joint adjustment has them, full covariance"};
  Out<Points> surveyed{
      "surveyed", frame("frame=?F"),
      "what the readings alone say of the marks, at the same weights: what the model is compared with"};

  void run(Context& context) override {
    const auto network = adjusted_network(context);
    TagBlockBuilder builder(camera.unpack(), plates.unpack(), poses.unpack());
    builder.set_prior(*self_calibration == "prior");
    if (frames && frames->fitted_to_design())
      builder.set_fitted(frames->origin() ? frames->origin()->str() : "", frames->datum_sigma());
    if (known) builder.set_fitted(known.unpack());
    for (size_t i = 0; i < observations.size(); ++i) builder.add_image(observations.unpack(i), *corner_sigma);
    for (const auto& warning : builder.warnings()) context.warn(warning);
    joint::JointOptions how;
    how.block = tag_options();
    how.estimate_survey_variance = *estimate_survey_variance;
    const FrameLink link =
        frames ? frame_link(frames.unpack(), "block", "survey") : FrameLink{"block", "survey", "", {}};
    const joint::JointResult result = joint::adjust_jointly(builder.block(), marks_of(*network), *network, link, how);
    report(context, builder.block(), result.block);
    for (size_t k = 0; k < std::min<size_t>(result.conspicuous.size(), 5); ++k)
      context.warn("survey and photographs together do not fit the " + result.conspicuous[k].what +
                   ": w = " + std::to_string(result.conspicuous[k].w));
    context.metric("survey_variance_factor", result.survey_variance, "1");
    context.metric("image_variance_factor", result.block.image_variance_factor, "1");
    context.metric("relinearisations", result.iterations, "1");
    points.commit(builder.points(result.block));
    adjusted_camera.commit(builder.camera(result.block));
    adjusted_poses.commit(builder.poses(result.block));
    BlockT artifact = builder.describe(result.block, how.block);
    artifact.adjuster = info.kind;
    block.commit(artifact);
    survey_points.commit(points_artifact(result.survey_ids, result.survey_positions, result.survey_covariance));
    Eigen::VectorXd alone(3 * static_cast<Eigen::Index>(result.surveyed_ids.size()));
    for (size_t k = 0; k < result.surveyed_ids.size(); ++k)
      alone.segment<3>(static_cast<Eigen::Index>(3 * k)) = result.surveyed.positions[k];
    surveyed.commit(points_artifact(result.surveyed_ids, alone, result.surveyed.covariance));
  }

 private:
  std::unique_ptr<survey::KeptNetwork> adjusted_network(Context& context) const {
    std::vector<survey::SurveyObservations> files;
    for (size_t i = 0; i < survey.size(); ++i) files.push_back(survey::from_artifact(survey.unpack(i)));
    if (files.empty()) throw std::runtime_error("'survey' holds no survey file");
    survey::ControlPoints control;
    if (known) control = survey::control_from_artifact(known.unpack());
    const survey::MergedSurvey merged = survey::merge_surveys(files, {control.ids, *same_stations});
    survey::AdjustOptions o;
    static const std::map<std::string, survey::DatumMode> modes = {{"automatic", survey::DatumMode::automatic},
                                                                   {"file", survey::DatumMode::file},
                                                                   {"fixed", survey::DatumMode::fixed},
                                                                   {"weighted", survey::DatumMode::weighted},
                                                                   {"inner", survey::DatumMode::inner}};
    o.datum = modes.at(*datum);
    o.remove_blunders = *remove_blunders;
    for (const std::string& text : *exclude) o.exclude.push_back(survey::parse_exclusion(text));
    std::string remark;
    o.profile = survey::choose_profile(*profile, profile_file->path, merged.survey.info.instrument, remark);
    o.instruments = survey::choose_instruments(*profile, profile_file->path, merged.survey.instruments);
    if (!remark.empty()) context.warn(remark);
    std::unique_ptr<survey::KeptNetwork> kept;
    const survey::NetworkResult result = survey::adjust_network(merged.survey, o, control, kept);
    for (const auto* findings : {&merged.findings, &result.findings})
      for (const survey::Finding& finding : *findings)
        if (finding.severity != survey::Finding::Severity::note) context.warn(finding.text);
    if (result.validity == survey::Validity::invalid)
      throw std::runtime_error(
          "the survey cannot be adjusted together with the photographs before its mistakes are "
          "mended (remove_blunders, exclude): " +
          result.verdict);
    if (result.validity != survey::Validity::sound) context.warn(result.verdict);
    return kept;
  }

  /// Anchors of plates that are no check anchors, called as points of the network.
  std::vector<joint::Mark> marks_of(const survey::KeptNetwork& network) const {
    std::vector<joint::Mark> marks;
    const PlatesT table = plates.unpack();
    for (size_t j = 0; j < table.plates.size(); ++j)
      if (table.plates[j]->role != "check" && network.has(table.plates[j]->anchor) &&
          network.position(table.plates[j]->anchor).allFinite())
        marks.push_back({table.plates[j]->anchor, static_cast<int>(j)});
    return marks;
  }

  /// Coordinates that do not exist are nan, and so is their covariance.
  static PointsT points_artifact(const std::vector<std::string>& ids, const Eigen::VectorXd& positions,
                                 Eigen::MatrixXd covariance) {
    for (Eigen::Index i = 0; i < positions.size(); ++i)
      if (std::isnan(positions(i)))
        covariance.row(i).setConstant(std::nan("")), covariance.col(i).setConstant(std::nan(""));
    PointsT artifact;
    for (size_t k = 0; k < ids.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(3 * k);
      auto point = std::make_unique<PointT>();
      point->id = ids[k];
      point->position = positions.segment<3>(at);
      point->sigma = covariance.diagonal().segment<3>(at).cwiseSqrt();
      artifact.points.push_back(std::move(point));
    }
    artifact.covariance = pack_symmetric(covariance);
    return artifact;
  }
};

}  // namespace plumbline::block
