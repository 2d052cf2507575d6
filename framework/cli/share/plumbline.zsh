#compdef plumbline
# Completion for zsh: commands, pipelines with their variables, kinds, artifacts, options. What there is, the program says.
_plumbline_words() {
  local program=$words[1] command=$words[2] current=$words[CURRENT]
  if ((CURRENT == 2)); then
    $program --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]\{1,\}\) .*/\1/p'
    print -l help version
  elif [[ $current == -* ]]; then
    $program $command --help 2>/dev/null | grep -oE -- '--[a-z-]+' | sort -u
  else
    case $command in
      run | watch | validate | plan | graph | verify)
        if ((CURRENT == 3)); then
          $program list pipelines 2>/dev/null | cut -d' ' -f1
        else
          $program describe $words[3] 2>/dev/null | sed -n '/^variables/,/^$/s/^  \([a-z_]\{1,\}\) .*/\1=/p'
        fi ;;
      describe) { $program list; $program list pipelines; $program list artifacts } 2>/dev/null | cut -d' ' -f1 ;;
      list) print -l nodes pipelines artifacts errors ;;
      campaign) ((CURRENT == 3)) && print -l init check ;;
      cache) ((CURRENT == 3)) && print prune ;;
      new) ((CURRENT == 3)) && print -l detector pose_solver adjuster registrar planner robot metric survey_reader writer python_node ;;
      bench) ((CURRENT == 3)) && print -l verify ${=$($program bench '?' 2>&1 | sed -n 's/^Bench files that can be run by name: //p')} ;;
      help) $program --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]\{1,\}\) .*/\1/p' ;;
    esac
  fi
}
_plumbline() {
  local -a offered=(${(f)"$(_plumbline_words)"})
  compadd -S '' -- ${(M)offered:#*=}
  compadd -- ${offered:#*=}
  [[ $words[CURRENT] == -* ]] || _files
}
# Loaded by its first use as the function of its own name, or read by hand, as from .zshrc.
if [[ $funcstack[1] == _plumbline ]]; then _plumbline "$@"; elif (($+functions[compdef])); then compdef _plumbline plumbline; fi
