// adjust.marker_board: photographs of tags whose places nobody knows, as a free network.
// colmap.sfm: a COLMAP model of photographs without markers. adjust.colmap_control: one with surveyed points.
// read.camera, read.plates: what is known beforehand.
// adjust.marker_start: the start of an adjustment under survey control.
// adjust.marker_field: photographs in a field of tags with an approximate layout.
#include "board_node.hpp"
#include "colmap_node.hpp"
#include "exchange_nodes.hpp"
#include "field_node.hpp"
#include "read_nodes.hpp"
#include "sfm_node.hpp"
#include "start_node.hpp"

PLUMBLINE_PLUGIN("markers", PLUMBLINE_BUILD_ID, "MIT", plumbline::markers::AdjustMarkerBoard,
                 plumbline::markers::AdjustMarkerField, plumbline::markers::ReadCamera, plumbline::markers::ReadPlates,
                 plumbline::markers::AdjustColmapControl, plumbline::markers::ColmapSfm, plumbline::markers::ReadPoints,
                 plumbline::markers::ReadImageObservations, plumbline::markers::ReadColmap,
                 plumbline::markers::WriteColmap, plumbline::markers::WriteGcp, plumbline::markers::WritePly,
                 plumbline::markers::AdjustMarkerStart)
