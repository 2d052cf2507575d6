# Completion for fish: commands, pipelines with their variables, kinds, artifacts, options. What there is, the program says.
function __plumbline_words
    set -l said (commandline -opc)
    set -l program $said[1]
    set -l command $said[2]
    set -l commands "/^Subcommands:/,\$s/^  \([a-z]\{1,\}\) .*/\1/p"
    if test (count $said) -eq 1
        $program --help 2>/dev/null | sed -n $commands
        printf '%s\n' help version
        return
    end
    if string match -q -- '-*' (commandline -ct)
        $program $command --help 2>/dev/null | grep -oE -- '--[a-z-]+' | sort -u
        return
    end
    set -l first (test (count $said) -eq 2; and echo yes)
    switch $command
        case run watch validate plan graph verify
            if test -n "$first"
                $program list pipelines 2>/dev/null | cut -d' ' -f1
            else
                $program describe $said[3] 2>/dev/null | sed -n '/^variables/,/^$/s/^  \([a-z_]\{1,\}\) .*/\1=/p'
            end
        case describe
            begin; $program list; $program list pipelines; $program list artifacts; end 2>/dev/null | cut -d' ' -f1
        case list
            printf '%s\n' nodes pipelines artifacts errors
        case campaign
            test -n "$first"; and printf '%s\n' init check
        case cache
            test -n "$first"; and echo prune
        case new
            test -n "$first"; and printf '%s\n' detector pose_solver adjuster registrar planner robot metric survey_reader writer python_node
        case bench
            test -n "$first"; and begin
                echo verify
                $program bench '?' 2>&1 | sed -n 's/^Bench files that can be run by name: //p' | string split -n ' '
            end
        case help
            $program --help 2>/dev/null | sed -n $commands
    end
end
complete -c plumbline -a '(__plumbline_words)'
