# SPDX-License-Identifier: Apache-2.0
# Completion for bash. What can follow is read from what --help says, so it is what the installed program knows.

_sheen() {
  local word=$2 previous=$3 program=$1 path=() help i
  local commands='/^Subcommands:/,/^$/s/^  \([a-z][a-z-]*\)\( .*\|$\)/\1/p'
  help=$("$program" --help 2> /dev/null)
  for ((i = 1; i < COMP_CWORD; ++i)); do
    sed -n "$commands" <<< "$help" | grep --quiet --line-regexp --fixed-strings -- "${COMP_WORDS[i]}" || continue
    path+=("${COMP_WORDS[i]}")
    help=$("$program" "${path[@]}" --help 2> /dev/null)
  done
  # The words that an option takes, as in "--model TEXT:{automatic,surface-light-field}".
  local values
  values=$(sed -n "s/^  \(-[a-z],\)\{0,1\}${previous//\//}[ ].*:{\([^}]*\)}.*/\2/p" <<< "$help")
  if [[ $previous == --* && $values ]]; then
    mapfile -t COMPREPLY < <(compgen -W "${values//,/ }" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(grep --only-matching -E '^ +(-[a-zA-Z],)?--[a-z-]+' <<< "$help" | grep --only-matching -E -- '--[a-z-]+')" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$(sed -n "$commands" <<< "$help")" -- "$word")
    [[ ${#COMPREPLY[@]} -gt 0 ]] || { compopt -o filenames 2> /dev/null; mapfile -t COMPREPLY < <(compgen -f -- "$word"); }
  fi
}
complete -F _sheen sheen-tracker sheen-reconstructor
