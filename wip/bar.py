import sys; sys.path.insert(0,'/tmp/fe21')
from fit import *
data=[pickle.load(open(f,'rb')) for f in sorted(glob.glob('/tmp/fe21/data/*.pkl'))]
print(len(data))
for d in data:
    ref=q(d,d['rows'][3],1.2)
    print(d['seed'],d['part'],d['features'])
    for lev in range(3):
        r=d['rows'][lev]; a=q(d,r,0); b=q(d,r,1.0)
        print('   ',r['unknowns'],'plain err %',np.round(100*(a/ref-1),2),'f*',np.round((ref-a)/(b-a),2))
