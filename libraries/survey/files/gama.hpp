// Input of GNU Gama's gama-local (gama-local.xsd): points, clusters of observations with covariance matrices, vectors,
// observed coordinates, height differences; angles in gon or as "d-m-s", axes and senses of any of the eight kinds.
#pragma once

#include <string>
#include <string_view>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

/// Reads a gama-local XML network. Every <obs from="..."> is a set-up with one orientation unknown. Points keep their
/// roles: `fix` fixed, `adj` free (small letters) or constrained (capitals), neither: unused. Standard deviations:
/// stdev, the cov-mat of the cluster, or the defaults of <points-observations>; a height difference without one gets
/// sigma-apr * sqrt(dist / km) mm. Units of the file: m, gon or d-m-s; mm, cc (arc seconds where the value is d-m-s).
/// Observations that cannot be used are listed as skipped. Throws SurveyReadError when the file is no gama-local input
/// or holds nothing. Likewise of a gama-g3 network (gnu-gama-data): vectors, observed places, distances and level
/// differences of the earth, E and N on a plane about its middle that is named as its map.
SurveyObservations read_gama_xml(std::string_view bytes, const std::string& file);

/// gama-local XML with axes-xy="en", left-handed angles, gon, cc and mm, to the last digit of a double. Means of faces
/// must have been taken: throws std::runtime_error for readings in face 2, observations without sigma, and local
/// coordinates, which the format cannot hold.
std::string write_gama_xml(const SurveyObservations& survey);

/// Radians of "57-32-28.428" (d-m-s, optional leading sign); false if `text` is no such angle.
bool parse_degrees_minutes_seconds(std::string_view text, double& radians);

}  // namespace plumbline::survey
