# Completion for bash: commands, pipelines with their variables, kinds, artifacts, options. What there is, the program says.
_plumbline() {
  local cur=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]:-} program=${COMP_WORDS[0]}
  local words=""
  if ((COMP_CWORD == 1)); then
    words=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]\{1,\}\) .*/\1/p')" help version"
  elif [[ $cur == -* ]]; then
    words=$("$program" "$command" --help 2>/dev/null | grep -oE -- '--[a-z-]+' | sort -u)
  else
    case $command in
      run | watch | validate | plan | graph | verify)
        if ((COMP_CWORD == 2)); then
          words=$("$program" list pipelines 2>/dev/null | cut -d' ' -f1)
        else
          words=$("$program" describe "${COMP_WORDS[2]}" 2>/dev/null | sed -n '/^variables/,/^$/s/^  \([a-z_]\{1,\}\) .*/\1=/p')
          compopt -o nospace 2>/dev/null  # outside of a completion, as in a test, there is none
        fi ;;
      describe) words=$({ "$program" list; "$program" list pipelines; "$program" list artifacts; } 2>/dev/null | cut -d' ' -f1) ;;
      list) words="nodes pipelines artifacts errors" ;;
      campaign) ((COMP_CWORD == 2)) && words="init check" ;;
      cache) ((COMP_CWORD == 2)) && words="prune" ;;
      new) ((COMP_CWORD == 2)) && words="detector pose_solver adjuster registrar planner robot metric survey_reader writer python_node" ;;
      bench) ((COMP_CWORD == 2)) && words="verify $("$program" bench '?' 2>&1 | sed -n 's/^Bench files that can be run by name: //p')" ;;
      help) words=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]\{1,\}\) .*/\1/p') ;;
    esac
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
}
complete -o default -F _plumbline plumbline
