// A pipeline as a picture: Graphviz DOT and Mermaid.
#include "runtime/graph.hpp"

namespace plumbline::runtime {

namespace {

std::string type_name(const GraphNode& node, const std::string& port) {
  const std::string type = node.kind.output(port)->type;
  const size_t dot = type.rfind('.');
  std::string name = type.substr(dot + 1, type.find('/') - dot - 1);
  const auto frames = node.output_frames.find(port);
  if (frames != node.output_frames.end() && frames->second.rfind("frame=", 0) == 0 && frames->second[6] != '?')
    name += " in " + frames->second.substr(6);
  return name;
}

}  // namespace

std::string to_dot(const Graph& graph) {
  std::string text =
      "digraph pipeline {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n"
      "  edge [fontname=\"sans-serif\", fontsize=10];\n";
  for (const GraphNode& node : graph.nodes)
    text += "  \"" + node.name + "\" [label=\"" + node.name + "\\n" + node.kind.node->kind + "\"];\n";
  for (const GraphNode& node : graph.nodes)
    for (const auto& [port, source] : node.inputs) {
      const GraphNode& from = graph.nodes[source.node];
      text += "  \"" + from.name + "\" -> \"" + node.name + "\" [label=\"" + type_name(from, source.port) + "\"];\n";
    }
  for (const GraphOutput& output : graph.outputs) {
    text += "  \"" + output.file + "\" [shape=note, style=solid];\n";
    text += "  \"" + graph.nodes[output.from.node].name + "\" -> \"" + output.file + "\";\n";
  }
  return text + "}\n";
}

std::string to_mermaid(const Graph& graph) {
  std::string text = "flowchart LR\n";
  for (const GraphNode& node : graph.nodes)
    text += "  " + node.name + "[\"" + node.name + "<br/><i>" + node.kind.node->kind + "</i>\"]\n";
  for (const GraphNode& node : graph.nodes)
    for (const auto& [port, source] : node.inputs) {
      const GraphNode& from = graph.nodes[source.node];
      text += "  " + from.name + " -- " + type_name(from, source.port) + " --> " + node.name + "\n";
    }
  for (size_t i = 0; i < graph.outputs.size(); ++i) {
    const GraphOutput& output = graph.outputs[i];
    text += "  " + graph.nodes[output.from.node].name + " --> out" + std::to_string(i) + "([" + output.file + "])\n";
  }
  return text;
}

}  // namespace plumbline::runtime
