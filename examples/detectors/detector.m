% A detector for `stiction bench detector`, in Octave without any package.
%
%   stiction bench detector 'octave-cli --quiet detector.m' --suite v1-trial
%
% It reads a recording as JSON in each line of standard input, and writes an answer as JSON. The score is minus the
% kurtosis of the OP: -1.8 for a triangle, -3 for noise.
1;

while true
  % fgetl would wait for the line after the next one.
  try
    line = input ("", "s");
  catch
    break
  end
  recording = jsondecode (line);
  op = recording.op(! isnan (recording.op));
  second = mean ((op - mean (op)) .^ 2);
  if second > 0
    score = -mean ((op - mean (op)) .^ 4) / second ^ 2;
    decision = "does not stick";
    if score > -1.9
      decision = "sticks";
    end
    printf ("{\"id\":\"%s\",\"score\":%.17g,\"decision\":\"%s\"}\n", recording.id, score, decision);
  else
    printf ("{\"id\":\"%s\",\"decision\":\"abstain\"}\n", recording.id);
  end
  fflush (stdout);
end
