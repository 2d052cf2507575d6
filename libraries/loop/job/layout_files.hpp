// Points for layout tools, and staked points back.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "artifacts/actuals.hpp"
#include "artifacts/installation_plan.hpp"
#include "loop/job/job.hpp"
#include "loop/job/survey_link.hpp"

namespace plumbline::loop {

enum class LayoutFormat { hilti, trimble, leica };  ///< PtID;E;N;H - name,N,E,elevation,code - PtID,E,N,H,code

struct LayoutPoint {
  std::string name;
  Eigen::Vector3d position;  ///< E, N, H [m]
  std::string code;
};

/// Four digits after the point (0.1 mm). Names with a separator in them are refused with std::runtime_error.
std::string layout_csv(const std::vector<LayoutPoint>& points, LayoutFormat format);

/// Brackets of the job where they are to be set, in its order; code: GO. What waits, hangs or is set already is staked
/// by nobody.
std::vector<LayoutPoint> layout_points(const Job& job);

/// DXF R12: a POINT for each bracket of the job on BRACKET_GO, and so that these are found on the wall a closed 3D
/// POLYLINE for each panel that the job hangs or that hangs on one of them, on a layer by its gate (PANEL_GO,
/// PANEL_HOLD, PANEL_NO_GO) or PANEL_HUNG; control on CONTROL. All in the frame of the job: `survey` is what it was
/// turned by.
std::string layout_dxf(const InstallationPlanT& plan, const Job& job, const std::vector<LayoutPoint>& control,
                       const SurveyLink& survey = {});

/// Staked points of such a file as reports "done" with their place. `format`: which tool wrote it, and so in which
/// order; a head that names E, N and H (in words of English or German) goes before it, as do a name's and a time
/// stamp's column. Columns that it names otherwise, and a head that names none of the coordinates, are named in
/// `ignored`. Decimal commas are read where ';' separates. What is no point is refused with its line: too few columns,
/// no number, a name twice. Throws std::runtime_error if the head says a unit other than metres, or one thing of two
/// columns. The tool was set up on control: its points are in the frame of the survey.
ActualsT read_staked(const std::string& text, LayoutFormat format, const std::string& source,
                     const SurveyLink& survey = {});

/// actuals.json: {"items": [{"item", "job", "revision", "by", "at", "outcome", "measured": [E, N, H], "sigma": [...],
/// "setting": {right, up, out}, "note"}]}, with "units" (metres) and "frame" ("building" or "survey") of the file or of
/// an entry if it likes; where these two differ a place needs it. Throws std::runtime_error if it is no such file;
/// single entries that are wrong, or have a key that seems to mean another one, are refused by name. Other keys are
/// named in `ignored`.
ActualsT read_actuals_json(const std::string& text, const std::string& source, const SurveyLink& survey = {});

}  // namespace plumbline::loop
