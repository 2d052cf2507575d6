// A pipeline as a picture: Graphviz DOT and Mermaid. Names are the user's own words, and stand in both within quotes.
#include "runtime/graph/graph.hpp"

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

/// A string of DOT, in its quotes.
std::string dot_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
  return quoted + "\"";
}

/// Text in a label of Mermaid, which knows the entities of HTML.
std::string mermaid_text(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    const bool plain = c != '"' && c != '<' && c != '>' && c != '&' && c != '#' && c != ';' && c != '`';
    escaped += plain ? std::string(1, c) : "#" + std::to_string(static_cast<int>(c)) + ";";
  }
  return escaped;
}

}  // namespace

std::string to_dot(const Graph& graph) {
  std::string text =
      "digraph pipeline {\n  rankdir=LR;\n  node [shape=box, style=rounded, fontname=\"sans-serif\"];\n"
      "  edge [fontname=\"sans-serif\", fontsize=10];\n";
  for (const GraphNode& node : graph.nodes) {
    std::string label = dot_text(node.name);
    label.insert(label.size() - 1, std::string("\\n") + node.kind.node->kind);
    text += "  " + dot_text(node.name) + " [label=" + label + "];\n";
  }
  const auto edge = [&](const Source& source, const GraphNode& node, const std::string& style) {
    const GraphNode& from = graph.nodes[source.node];
    text += "  " + dot_text(from.name) + " -> " + dot_text(node.name) +
            " [label=" + dot_text(type_name(from, source.port)) + style + "];\n";
  };
  for (const GraphNode& node : graph.nodes) {
    for (const auto& [port, source] : node.inputs) edge(source, node, "");
    for (const Carry& carry : graph.rounds.carry) {
      for (const auto& [port, name] : node.carried)
        if (name == carry.name) edge(carry.next, node, ", style=dashed, constraint=false");
      for (const auto& [port, name] : node.collected)
        if (name == carry.name) edge(carry.next, node, ", style=bold");
    }
  }
  for (const GraphOutput& output : graph.outputs) {
    // Not the name alone: a node may have it, too.
    const std::string id = dot_text("output " + output.file);
    text += "  " + id + " [label=" + dot_text(output.file) + ", shape=note, style=solid];\n";
    text += "  " + dot_text(graph.nodes[output.from.node].name) + " -> " + id + ";\n";
  }
  return text + "}\n";
}

std::string to_mermaid(const Graph& graph) {
  std::string text = "flowchart LR\n";
  const auto id = [](size_t node) { return "n" + std::to_string(node); };
  for (size_t i = 0; i < graph.nodes.size(); ++i)
    text += "  " + id(i) + "[\"" + mermaid_text(graph.nodes[i].name) + "<br/><i>" + graph.nodes[i].kind.node->kind +
            "</i>\"]\n";
  const auto edge = [&](const Source& source, size_t node, const char* line, const char* head) {
    const std::string label = mermaid_text(type_name(graph.nodes[source.node], source.port));
    text += "  " + id(source.node) + " " + line + " \"" + label + "\" " + head + " " + id(node) + "\n";
  };
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    for (const auto& [port, source] : graph.nodes[i].inputs) edge(source, i, "--", "-->");
    for (const Carry& carry : graph.rounds.carry) {
      for (const auto& [port, name] : graph.nodes[i].carried)
        if (name == carry.name) edge(carry.next, i, "-.", ".->");
      for (const auto& [port, name] : graph.nodes[i].collected)
        if (name == carry.name) edge(carry.next, i, "==", "==>");
    }
  }
  for (size_t i = 0; i < graph.outputs.size(); ++i) {
    const GraphOutput& output = graph.outputs[i];
    text +=
        "  " + id(output.from.node) + " --> out" + std::to_string(i) + "([\"" + mermaid_text(output.file) + "\"])\n";
  }
  return text;
}

}  // namespace plumbline::runtime
